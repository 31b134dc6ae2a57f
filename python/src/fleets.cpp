// Fleets of linkages, and distances between curves.
#include "module.hpp"

namespace assur::python {
namespace {

std::vector<PlanePoint> curve_of(const Array& points) {
  if (points.ndim() != 2 || points.shape(1) != 2) {
    throw Error(Error::Kind::input, "a curve is an array of (points, 2)");
  }
  std::vector<PlanePoint> out(static_cast<std::size_t>(points.shape(0)));
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = {points.data()[2 * i], points.data()[2 * i + 1]};
  return out;
}

void add_distance(py::module_& m, const char* name,
                  double (*distance)(std::span<const PlanePoint>, std::span<const PlanePoint>), const char* doc) {
  m.def(
      name, [distance](const Array& a, const Array& b) { return distance(curve_of(a), curve_of(b)); }, py::arg("a"),
      py::arg("b"), doc);
}

const char* kind_of(const LinkageJoint& joint) {
  constexpr const char* kNames[] = {"ground", "crank", "dyad", "point", "triad"};
  return kNames[static_cast<std::size_t>(joint.kind)];
}

}  // namespace

void add_fleets(py::module_& m) {
  py::class_<LinkageJoint>(m, "LinkageJoint", R"(A joint of a planar linkage. Lengths in m, angles in rad.)")
      .def_static("ground", &LinkageJoint::ground, py::arg("x"), py::arg("y"), "A fixed joint.")
      .def_static("crank", &LinkageJoint::crank, py::arg("first"), py::arg("radius"), py::arg("angle"),
                  py::arg("speed"), "Turns about the joint `first`: at time t its angle is angle + speed t (rad/s).")
      .def_static("dyad", &LinkageJoint::dyad, py::arg("first"), py::arg("second"), py::arg("to_first"),
                  py::arg("to_second"), py::arg("left"),
                  "At two distances from two joints, on the left or right of the line from the first to the second.")
      .def_static("point", &LinkageJoint::point, py::arg("first"), py::arg("second"), py::arg("along"),
                  py::arg("across"), "On a link that holds both joints: along and across in parts of their distance.")
      .def_static(
          "triad", &LinkageJoint::triad, py::arg("first"), py::arg("to_first"), py::arg("x"), py::arg("y"),
          "One of three joints in a row on one link, at a distance from a joint; x, y in an approximate posture.")
      .def("__repr__", [](const LinkageJoint& j) {
        return py::str("LinkageJoint.{}({}, {}, {}, {}, {})")
            .format(kind_of(j), j.first, j.second, j.value[0], j.value[1], j.value[2])
            .cast<std::string>();
      });

  py::class_<Fleet>(m, "Fleet", R"(Many planar linkages of any structure, given as lists of LinkageJoint.)")
      .def(py::init([](const std::vector<std::vector<LinkageJoint>>& linkages) {
             std::vector<Linkage> all;
             for (const auto& joints : linkages) all.push_back({joints, Linkage::kLast});
             return Fleet(std::move(all));
           }),
           py::arg("linkages"), "The last joint of each linkage is traced.")
      .def("__len__", &Fleet::size)
      .def(
          "run",
          [](const Fleet& fleet, const Array& times, int threads, double accuracy) {
            const std::vector<double> at = numbers(times);
            const auto rows = static_cast<py::ssize_t>(at.size()), count = static_cast<py::ssize_t>(fleet.size());
            py::array_t<double> paths({count, rows, py::ssize_t{2}}), reached(count);
            std::vector<std::string> status(fleet.size());
            double* const xy = paths.mutable_data();
            double* const ends = reached.mutable_data();
            {
              const py::gil_scoped_release release;
              (void)fleet.run(at,
                              [&](std::size_t i, const LinkageMotion& motion) {
                                double* to = xy + i * at.size() * 2;
                                for (const PlanePoint& p : motion.path) to = std::copy(p.begin(), p.end(), to);
                                std::fill(to, xy + (i + 1) * at.size() * 2, std::numeric_limits<double>::quiet_NaN());
                                ends[i] = motion.reached;
                                status[i] = name(motion.status.code);
                              },
                              {.threads = threads, .accuracy = accuracy});
            }
            return py::make_tuple(paths, reached, status);
          },
          py::arg("times"), py::kw_only(), py::arg("threads") = 1, py::arg("accuracy") = 1e-6,
          R"(Moves all linkages over `times` (s). Returns (paths, reached, status).

paths: an array of (linkages, times, 2), m, of the traced joints; NaN where a linkage has jammed. reached: the last time
of each linkage, s. status: 'ok', 'limit_reached', ... of each.)")
      .def("__repr__", [](const Fleet& f) { return "Fleet(" + plural(f.size(), "linkage") + ")"; });

  add_distance(m, "timed_distance", &timed_distance, "Root mean square distance of points with the same index, m.");
  add_distance(m, "nearest_distance", &nearest_distance,
               "Root mean square distance of each point of one curve from the nearest of the other, both ways, m.");
  add_distance(m, "fitted_distance", &fitted_distance,
               "timed_distance() after `a` is scaled, turned and moved onto `b` as closely as possible.");
  add_distance(m, "shape_distance", &shape_distance,
               "nearest_distance() of both curves in their normal places: centered, radius 1, longest along x.");
}

}  // namespace assur::python
