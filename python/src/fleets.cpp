// Fleets of linkages, and distances between curves.
#include <atomic>
#include <thread>

#include "module.hpp"
#include "sweep/random_linkage.hpp"

namespace assur::python {
namespace {

sweep::JointCounts counts_of(std::pair<int, int> joints) {
  using sweep::JointCounts;
  if (joints.first < JointCounts::kFewest || joints.second < joints.first || joints.second > JointCounts::kMost) {
    throw Error(Error::Kind::input, "joints: (fewest, most) from " + std::to_string(JointCounts::kFewest) + " to " +
                                        std::to_string(JointCounts::kMost));
  }
  return {joints.first, joints.second};
}

// The arguments of the function that makes this joint.
py::tuple arguments_of(const LinkageJoint& j) {
  using Kind = LinkageJoint::Kind;
  switch (j.kind) {
    case Kind::ground:
      return py::make_tuple(j.value[0], j.value[1]);
    case Kind::crank:
      return py::make_tuple(j.first, j.value[0], j.value[1], j.value[2]);
    case Kind::dyad:
      return py::make_tuple(j.first, j.second, j.value[0], j.value[1], j.left);
    case Kind::point:
      return py::make_tuple(j.first, j.second, j.value[0], j.value[1]);
    case Kind::triad:
      break;
  }
  return py::make_tuple(j.first, j.value[0], j.value[1], j.value[2]);
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

void add_curves(py::module_& m) {
  py::class_<CurveFrame>(m, "CurveFrame",
                         R"(How a curve is moved to its normal place, where it is centered, with radius 1
and its longest direction along x: points p become (p - center) / radius, turned by -angle.)")
      .def_readonly("center", &CurveFrame::center, "Mean of the points: (x, y), m.")
      .def_readonly("radius", &CurveFrame::radius, "Root mean square of the distances from the center, m.")
      .def_readonly("angle", &CurveFrame::angle, "Of the direction in which the points spread most, rad.");
  m.def(
      "frame_of", [](const Array& curve) { return frame_of(curve_of(curve)); }, py::arg("curve"),
      "The CurveFrame of a curve: an array of (points, 2), m.");
  m.def(
      "normalize",
      [](const Array& curve) {
        std::vector<PlanePoint> points = curve_of(curve);
        normalize(points, frame_of(points), points);
        return Array({static_cast<py::ssize_t>(points.size()), py::ssize_t{2}}, points.data()->data());
      },
      py::arg("curve"), "The curve in its normal place: an array of (points, 2), without unit, of one in m.");
  add_distance(m, "timed_distance", &timed_distance,
               "Root mean square distance of points with the same index, m. Curves are arrays of (points, 2), m.");
  add_distance(
      m, "nearest_distance", &nearest_distance,
      "Root mean square distance of each point of one curve from the nearest of the other, both ways, m. Curves "
      "are arrays of (points, 2), m.");
  add_distance(m, "fitted_distance", &fitted_distance,
               "timed_distance() after `a` is scaled, turned and moved onto `b` as closely as possible, m. Curves are "
               "arrays of (points, 2), m.");
  add_distance(m, "shape_distance", &shape_distance,
               "nearest_distance() of both curves in their normal places: centered, radius 1, longest along x; without "
               "unit. Curves are arrays of (points, 2), m.");
}

}  // namespace

std::vector<PlanePoint> curve_of(const Array& points) {
  if (points.ndim() != 2 || points.shape(1) != 2) {
    throw Error(Error::Kind::input, "a curve is an array of (points, 2)");
  }
  std::vector<PlanePoint> out(static_cast<std::size_t>(points.shape(0)));
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = {points.data()[2 * i], points.data()[2 * i + 1]};
  return out;
}

void add_fleets(py::module_& m) {
  py::class_<LinkageJoint>(m, "LinkageJoint", R"(A joint of a planar linkage. Lengths in m, angles in rad.)")
      .def_static("ground", &LinkageJoint::ground, py::arg("x"), py::arg("y"), "A fixed joint at (x, y), m.")
      .def_static("crank", &LinkageJoint::crank, py::arg("first"), py::arg("radius"), py::arg("angle"),
                  py::arg("speed"), "Turns about the joint `first`: at time t its angle is angle + speed t (rad/s).")
      .def_static(
          "dyad", &LinkageJoint::dyad, py::arg("first"), py::arg("second"), py::arg("to_first"), py::arg("to_second"),
          py::arg("left"),
          "At two distances (m) from two joints, on the left or right of the line from the first to the second.")
      .def_static("point", &LinkageJoint::point, py::arg("first"), py::arg("second"), py::arg("along"),
                  py::arg("across"),
                  "On a link that holds both joints: along and across in parts of their distance, without unit.")
      .def_static(
          "triad", &LinkageJoint::triad, py::arg("first"), py::arg("to_first"), py::arg("x"), py::arg("y"),
          "One of three joints in a row on one link, at a distance from a joint; x, y in an approximate posture; m.")
      .def_property_readonly("kind", &kind_of, "'ground', 'crank', 'dyad', 'point' or 'triad'.")
      .def_readonly("first", &LinkageJoint::first, "Index of the first parent.")
      .def_readonly("second", &LinkageJoint::second, "Index of the second parent.")
      .def_readonly("left", &LinkageJoint::left, "Of a dyad: on the left of the line from `first` to `second`.")
      .def_readonly("value", &LinkageJoint::value,
                    "Three numbers: (x, y, 0), (radius, angle, speed), (to_first, to_second, 0), ...; m, rad, rad/s.")
      .def(
          "__eq__",
          [](const LinkageJoint& a, const LinkageJoint& b) {
            return a.kind == b.kind && arguments_of(a).equal(arguments_of(b));
          },
          py::is_operator())
      .def("__hash__", [](const LinkageJoint& j) { return py::hash(arguments_of(j)); })
      .def("__repr__", [](const LinkageJoint& j) {
        return std::string("LinkageJoint.") + kind_of(j) + py::repr(arguments_of(j)).cast<std::string>();
      });

  py::class_<Fleet>(m, "Fleet", R"(Many planar linkages of any structure, given as lists of LinkageJoint.)")
      .def(py::init([](const std::vector<std::vector<LinkageJoint>>& linkages) {
             std::vector<Linkage> all;
             for (const auto& joints : linkages) all.push_back({joints, Linkage::kLast});
             return Fleet(std::move(all));
           }),
           py::arg("linkages"), "The last joint of each linkage is traced.")
      .def_static(
          "random",
          [](std::size_t count, std::uint64_t seed, std::uint64_t first, std::pair<int, int> joints) {
            return Fleet(count, [=, counts = counts_of(joints)](std::size_t i, Linkage& to) {
              sweep::random_linkage(seed, first + i, counts, to);
            });
          },
          py::arg("count"), py::kw_only(), py::arg("seed") = 0, py::arg("first") = 0,
          py::arg("joints") = std::pair(5, 20),
          "The linkages random_linkage(seed, k, joints) for k = first, first + 1, ..., which need no memory. They have "
          "no "
          "unit but m, rad and s.")
      .def("__len__", &Fleet::members)
      .def(
          "run",
          [](const Fleet& fleet, const Array& times, int threads, double accuracy, const py::object& progress) {
            const std::vector<double> at = numbers(times);
            const auto rows = static_cast<py::ssize_t>(at.size()), count = static_cast<py::ssize_t>(fleet.members());
            py::array_t<double> paths({count, rows, py::ssize_t{2}}), reached(count);
            std::vector<std::string> status(fleet.members(), std::string(name(Code::interrupted)));
            double* const xy = paths.mutable_data();
            double* const ends = reached.mutable_data();
            bool interrupted = false;
            (void)run_watched(progress, interrupted, [&](const Observer& observer) {
              const auto take = [&](std::size_t i, const LinkageMotion& motion) {
                double* to = xy + i * at.size() * 2;
                for (const PlanePoint& p : motion.path) to = std::copy(p.begin(), p.end(), to);
                std::fill(to, xy + (i + 1) * at.size() * 2, std::numeric_limits<double>::quiet_NaN());
                ends[i] = motion.reached;
                status[i] = name(motion.status.code);
              };
              return fleet.stream(take, at, {.threads = threads, .accuracy = accuracy, .observer = observer});
            });
            for (std::size_t i = 0; i < status.size() && interrupted; ++i) {
              if (status[i] != name(Code::interrupted)) continue;
              std::fill_n(xy + i * at.size() * 2, at.size() * 2, std::numeric_limits<double>::quiet_NaN());
              ends[i] = std::numeric_limits<double>::quiet_NaN();
            }
            const py::object result = py::make_tuple(paths, reached, status);
            if (interrupted) raise_interrupted(result);
            return result;
          },
          py::arg("times"), py::kw_only(), py::arg("threads") = 1, py::arg("accuracy") = 1e-6,
          py::arg("progress") = py::none(),
          R"(Moves all linkages over `times`, an array of (times,), s. Returns (paths, reached, status).

paths: an array of (linkages, times, 2), m, of the traced joints; NaN where a linkage has jammed. reached: an array of
(linkages,), the last time of each, s. status: 'ok', 'fold', ... of each. accuracy: a
motion with a larger estimated error, relative, is 'inaccurate'. Ctrl-C raises Interrupted, whose `result` has the
linkages that are done; the others are NaN, with the status 'interrupted'. progress: tqdm, or a bar of it.)")
      .def("__repr__", [](const Fleet& f) { return "Fleet(" + plural(f.members(), "linkage") + ")"; });

  m.def(
      "random_linkage",
      [](std::uint64_t seed, std::uint64_t k, std::pair<int, int> joints) {
        Linkage out;
        sweep::random_linkage(seed, k, counts_of(joints), out);
        return out.joints;
      },
      py::arg("seed"), py::arg("k"), py::arg("joints") = std::pair(5, 20),
      R"(Linkage k of the random linkages of `assur sweep linkages` with this seed: a list of LinkageJoint.

joints: the fewest and the most. A crank about the origin turns once in 1 s; the other joints, grounds and dyads, lie
in the square from -1 to 1 m at t = 0.)");
  m.def(
      "scene_of",
      [](const std::vector<LinkageJoint>& joints, double start, double end, double step, const std::string& name) {
        return scene_of({joints, Linkage::kLast}, {start, end, step}, name);
      },
      py::arg("linkage"), py::arg("start"), py::arg("end"), py::arg("step"), py::arg("name") = "linkage",
      R"(A linkage (a list of LinkageJoint) as a Scene, with points J0, J1, ... in their posture at `start`.

start, end, step: the time grid, s. Raises NumericalError if a dyad cannot be closed there.)");
  add_curves(m);
}

}  // namespace assur::python
