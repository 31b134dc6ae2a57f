// SceneBuilder: one method for each kind of part.
#include <pybind11/functional.h>
#include "module.hpp"

namespace assur::python {
namespace {

// (x, y) or (x, y, z).
Triple triple_of(const py::sequence& at) {
  if (at.size() != 2 && at.size() != 3) {
    throw Error(Error::Kind::input, "a place or direction has 2 or 3 numbers, not " + std::to_string(at.size()));
  }
  return {at[0].cast<double>(), at[1].cast<double>(), at.size() == 3 ? at[2].cast<double>() : 0.};
}

bool is_text(const py::object& o) { return py::isinstance<py::str>(o); }

// The name of a vector, or two names of points.
Direction direction_of(const py::object& d) {
  if (is_text(d)) return {d.cast<std::string>()};
  const auto [from, to] = d.cast<std::pair<std::string, std::string>>();
  return {from, to};
}

// The name of a point or vector, or numbers.
Anchor anchor_of(const py::object& at) {
  if (is_text(at)) return at.cast<std::string>();
  return triple_of(at.cast<py::sequence>());
}

std::vector<Member> members_of(const py::dict& members, bool in_ground) {
  std::vector<Member> out;
  for (const auto& [name, at] : members) {
    out.push_back({name.cast<std::string>(), triple_of(at.cast<py::sequence>()), in_ground});
  }
  return out;
}

using Names = std::vector<std::string>;
// Numbers of the program as an array for a function of Python, and its answer.
void call(const py::function& function, std::span<double> to, const char* what, std::span<const double> x,
          std::span<const double> rates = {}) {
  const py::gil_scoped_acquire lock;
  const auto array = [](std::span<const double> of) { return Array(static_cast<py::ssize_t>(of.size()), of.data()); };
  const py::object answer = rates.empty() ? function(array(x)) : function(array(x), array(rates));
  const auto numbers = answer.cast<Array>();
  if (numbers.size() != static_cast<py::ssize_t>(to.size())) {
    throw Error(Error::Kind::input, std::string(what) + " must return " + plural(to.size(), "number") + ", not " +
                                        std::to_string(numbers.size()));
  }
  std::copy_n(numbers.data(), to.size(), to.begin());
}

}  // namespace

void add_builder(py::module_& m) {
  const auto self = py::return_value_policy::reference_internal;
  using B = SceneBuilder;
  py::class_<B>(m, "SceneBuilder", R"(Builds a scene part by part; build() checks all parts and names every error.

Places and directions are (x, y) or (x, y, z), m. A direction is the name of a vector, or a pair of names of points.
Each method returns the builder. Names of parts are unique.)")
      .def(py::init<std::string, int>(), py::arg("name"), py::arg("dimension"), "dimension: 2 (plane) or 3 (space).")
      .def(
          "point",
          [](B& b, const std::string& name, const py::sequence& at, bool fixed) -> B& {
            return b.add(Point{name, triple_of(at), fixed});
          },
          py::arg("name"), py::arg("at"), py::arg("fixed") = false, self,
          "A point at `at`, m: a first guess unless it is fixed, and also gives lengths that are left out.")
      .def(
          "vector",
          [](B& b, const std::string& name, const py::sequence& at, bool fixed, bool unit) -> B& {
            return b.add(Vector{name, triple_of(at), fixed, unit});
          },
          py::arg("name"), py::arg("at"), py::arg("fixed") = false, py::arg("unit") = true, self, "A unit vector.")
      .def(
          "body",
          [](B& b, const std::string& name, const Names& base, const py::dict& points, const py::dict& vectors,
             const std::string& origin, const Names& frame, const Names& rigid, bool in_ground) -> B& {
            return b.add(
                Body{name, origin, frame, base, members_of(points, in_ground), members_of(vectors, in_ground), rigid});
          },
          py::arg("name"), py::kw_only(), py::arg("base") = Names{}, py::arg("points") = py::dict(),
          py::arg("vectors") = py::dict(), py::arg("origin") = "", py::arg("frame") = Names{},
          py::arg("rigid") = Names{}, py::arg("in_ground") = false, self,
          "A body with members: points and vectors are dicts of names and local coordinates, m (in_ground: ground "
          "coordinates). Its base is `base`, `origin` and `frame`, `rigid`, or follows from joints: docs/scenes.md.")
      // ---- joints
      .def(
          "revolute",
          [](B& b, const std::string& name, const std::string& of, const std::string& to, const py::object& at,
             const py::object& axis) -> B& {
            return b.joint(name, Revolute{of, to, anchor_of(at), axis.is_none() ? Anchor{} : anchor_of(axis)});
          },
          py::arg("name"), py::arg("a"), py::arg("b"), py::arg("at"), py::arg("axis") = py::none(), self,
          "One rotation of body b about an axis of body a; coordinate 'NAME.angle', rad. axis: in space.")
      .def(
          "prismatic",
          [](B& b, const std::string& name, const std::string& of, const std::string& to,
             const py::object& axis) -> B& {
            return b.joint(name, Prismatic{of, to, anchor_of(axis)});
          },
          py::arg("name"), py::arg("a"), py::arg("b"), py::arg("axis"), self,
          "One translation; coordinate 'NAME.displacement', m.")
      .def(
          "cylindrical",
          [](B& b, const std::string& name, const std::string& of, const std::string& to, const py::object& at,
             const py::object& axis) -> B& {
            return b.joint(name, Cylindrical{of, to, anchor_of(at), anchor_of(axis)});
          },
          py::arg("name"), py::arg("a"), py::arg("b"), py::arg("at"), py::arg("axis"), self,
          "Rotation about an axis and translation along it, in space; coordinates 'NAME.angle', rad, "
          "'NAME.displacement', m.")
      .def(
          "spherical",
          [](B& b, const std::string& name, const std::string& of, const std::string& to, const py::object& at) -> B& {
            return b.joint(name, Spherical{of, to, anchor_of(at)});
          },
          py::arg("name"), py::arg("a"), py::arg("b"), py::arg("at"), self,
          "All rotations about a point (`at`, m), in space.")
      .def(
          "universal",
          [](B& b, const std::string& name, const std::string& of, const std::string& to, const py::object& at,
             const py::object& axis_a, const py::object& axis_b) -> B& {
            return b.joint(name, Universal{of, to, anchor_of(at), anchor_of(axis_a), anchor_of(axis_b)});
          },
          py::arg("name"), py::arg("a"), py::arg("b"), py::arg("at"), py::arg("axis_a"), py::arg("axis_b"), self,
          "Two rotations about axes at right angles through `at` (m), the first fixed to a, the second to b.")
      .def(
          "planar",
          [](B& b, const std::string& name, const std::string& of, const std::string& to,
             const py::object& normal) -> B& {
            return b.joint(name, Planar{of, to, anchor_of(normal)});
          },
          py::arg("name"), py::arg("a"), py::arg("b"), py::arg("normal"), self,
          "Sliding and turning in a plane; the normal is a direction without unit.")
      .def(
          "fixed",
          [](B& b, const std::string& name, const std::string& of, const std::string& to) -> B& {
            return b.joint(name, Fixed{of, to});
          },
          py::arg("name"), py::arg("a"), py::arg("b"), self, "No motion between two bodies.")
      // ---- constraints
      .def(
          "distance",
          [](B& b, const std::string& name, const std::string& p, const std::string& q,
             std::optional<double> value) -> B& {
            return b.constrain(name, Distance{p, q, value});
          },
          py::arg("name"), py::arg("p"), py::arg("q"), py::arg("value") = py::none(), self,
          "The distance of two points is constant, m (None: as written).")
      .def(
          "equal_distance",
          [](B& b, const std::string& name, const std::string& p, const std::string& q, const std::string& r,
             const std::string& s) -> B& {
            return b.constrain(name, EqualDistance{p, q, r, s});
          },
          py::arg("name"), py::arg("p"), py::arg("q"), py::arg("r"), py::arg("s"), self, "|PQ| = |RS|.")
      .def(
          "dot",
          [](B& b, const std::string& name, const py::object& d, const py::object& e,
             std::optional<double> value) -> B& {
            return b.constrain(name, Dot{direction_of(d), direction_of(e), value});
          },
          py::arg("name"), py::arg("d"), py::arg("e"), py::arg("value") = py::none(), self,
          "The dot product of two directions is constant: value in m^2, m or without unit, as of its factors (None: as "
          "written).")
      .def(
          "parallel",
          [](B& b, const std::string& name, const py::object& d, const py::object& e) -> B& {
            return b.constrain(name, Parallel{direction_of(d), direction_of(e)});
          },
          py::arg("name"), py::arg("d"), py::arg("e"), self, "e = lambda d, with the unknown 'NAME.lambda'.")
      .def(
          "linear",
          [](B& b, const std::string& name, const std::map<std::string, double>& terms,
             const py::sequence& value) -> B& {
            return b.constrain(name, Linear{{terms.begin(), terms.end()}, triple_of(value)});
          },
          py::arg("name"), py::arg("terms"), py::arg("value") = py::make_tuple(0., 0.), self,
          "A sum of factors (without unit) times points or vectors is constant: value in m.")
      .def(
          "coordinate",
          [](B& b, const std::string& name, const std::string& coordinate, double value) -> B& {
            return b.constrain(name, FixedCoordinate{coordinate, value});
          },
          py::arg("name"), py::arg("coordinate"), py::arg("value") = 0., self, "One coordinate ('P.x', m) is constant.")
      .def(
          "on_line",
          [](B& b, const std::string& name, const std::string& p, const std::string& a, const py::object& d) -> B& {
            return b.constrain(name, OnLine{p, a, direction_of(d)});
          },
          py::arg("name"), py::arg("p"), py::arg("a"), py::arg("d"), self, "Point p is on the line from a along d.")
      .def(
          "on_plane",
          [](B& b, const std::string& name, const std::string& p, const std::string& a, const py::object& d,
             const py::object& e) -> B& {
            return b.constrain(name, OnPlane{p, a, direction_of(d), direction_of(e)});
          },
          py::arg("name"), py::arg("p"), py::arg("a"), py::arg("d"), py::arg("e"), self,
          "Point p is on the plane through a along d and e, in space.")
      .def(
          "gear",
          [](B& builder, const std::string& name, const std::string& a, const std::string& b, double ratio) -> B& {
            return builder.constrain(name, Gear{a, b, ratio});
          },
          py::arg("name"), py::arg("a"), py::arg("b"), py::arg("ratio"), self,
          "Two coordinates of joints move in proportion: b = ratio a; no unit, m/rad or rad/m.")
      .def(
          "equations",
          [](B& b, const std::string& name, const Names& coordinates, int equations, const py::function& residual,
             const py::function& jacobian, const py::function& curvature, double tolerance) -> B& {
            Callback c;
            c.coordinates = coordinates;
            c.equations = equations;
            c.tolerance = tolerance;
            c.residual = [f = shared(residual)](std::span<const double> x, std::span<double> to) {
              call(*f, to, "residual", x);
            };
            c.jacobian = [f = shared(jacobian)](std::span<const double> x, std::span<double> to) {
              call(*f, to, "jacobian", x);
            };
            c.curvature = [f = shared(curvature)](std::span<const double> x, std::span<const double> rates,
                                                  std::span<double> to) { call(*f, to, "curvature", x, rates); };
            return b.constrain(name, c);
          },
          py::arg("name"), py::arg("coordinates"), py::arg("equations"), py::kw_only(), py::arg("residual"),
          py::arg("jacobian"), py::arg("curvature"), py::arg("tolerance") = kDerivativeTolerance, self,
          R"(Equations that Python functions compute; slow, as each step calls them.

x: an array of the coordinates ('P.x', ...), SI units. residual(x): array of (equations,), which is 0 in a posture.
jacobian(x): array of (equations, coordinates). curvature(x, rates): array of (equations,), d/dt(J) rates.)")
      // ---- drivers
      .def(
          "drive_angle",
          [](B& b, const std::string& name, const std::string& from, const std::string& to, const Law& law,
             const py::object& axis, bool relative) -> B& {
            return b.drive(name, PointAngle{from, to, anchor_of(axis), law}, relative);
          },
          py::arg("name"), py::arg("a"), py::arg("b"), py::arg("law"), py::arg("axis") = "",
          py::arg("relative") = false, self,
          "Drives the direction from point a to point b, rad. In space about a fixed axis, numbers or the name of a "
          "vector. relative: from the posture "
          "as written.")
      .def(
          "drive_relative_angle",
          [](B& b, const std::string& name, const py::object& d, const py::object& e, const Law& law,
             const py::object& axis, bool relative) -> B& {
            return b.drive(name, RelativeAngle{direction_of(d), direction_of(e), anchor_of(axis), law}, relative);
          },
          py::arg("name"), py::arg("d"), py::arg("e"), py::arg("law"), py::arg("axis") = "",
          py::arg("relative") = false, self, "Drives the angle from one direction to another, rad.")
      .def(
          "drive_distance",
          [](B& b, const std::string& name, const std::string& from, const std::string& to, const Law& law,
             bool relative) -> B& {
            return b.drive(name, DrivenDistance{from, to, law}, relative);
          },
          py::arg("name"), py::arg("a"), py::arg("b"), py::arg("law"), py::arg("relative") = false, self,
          "Drives the distance of two points, m: a linear actuator.")
      .def(
          "drive_coordinate",
          [](B& b, const std::string& name, const std::string& coordinate, const Law& law, bool relative) -> B& {
            return b.drive(name, DrivenCoordinate{coordinate, law}, relative);
          },
          py::arg("name"), py::arg("coordinate"), py::arg("law"), py::arg("relative") = false, self,
          "Drives one coordinate: 'P.x' (m), 'JOINT.angle' (rad), 'JOINT.displacement' (m).")
      .def(
          "drive_pose",
          [](B& b, const std::string& name, const std::string& body, const std::vector<Law>& translation,
             const std::vector<Law>& rotation, bool relative) -> B& {
            return b.drive(name, Pose{body, translation, rotation}, relative);
          },
          py::arg("name"), py::arg("body"), py::arg("translation"), py::arg("rotation"), py::arg("relative") = false,
          self, "Drives a whole body: laws of its origin (m), and of psi, theta, phi (in the plane one angle), rad.")
      // ---- measures
      .def(
          "measure_angle",
          [](B& b, const std::string& name, const std::string& from, const std::string& to) -> B& {
            return b.measure(name, AbsoluteAngle{from, to});
          },
          py::arg("name"), py::arg("a"), py::arg("b"), self, "Direction from a to b, in the plane, rad.")
      .def(
          "measure_angle_between",
          [](B& b, const std::string& name, const py::object& d, const py::object& e, const py::object& axis) -> B& {
            return b.measure(name, AngleBetween{direction_of(d), direction_of(e), anchor_of(axis)});
          },
          py::arg("name"), py::arg("d"), py::arg("e"), py::arg("axis") = "", self, "Angle from d to e, rad.")
      .def(
          "measure_distance",
          [](B& b, const std::string& name, const std::string& from, const std::string& to) -> B& {
            return b.measure(name, MeasuredDistance{from, to});
          },
          py::arg("name"), py::arg("a"), py::arg("b"), self, "Distance of two points, m.")
      .def(
          "measure_coordinate",
          [](B& b, const std::string& name, const std::string& coordinate) -> B& {
            return b.measure(name, MeasuredCoordinate{coordinate});
          },
          py::arg("name"), py::arg("coordinate"), self, "One coordinate, in its unit.")
      .def(
          "measure_sum",
          [](B& b, const std::string& name, const std::map<std::string, double>& terms, double constant) -> B& {
            return b.measure(name, Combination{{terms.begin(), terms.end()}, constant});
          },
          py::arg("name"), py::arg("terms"), py::arg("constant") = 0., self,
          "Multiples of measures (factors without unit), and a constant in their unit.")
      .def(
          "limit",
          [](B& b, const std::string& quantity, double min, double max, bool ends) -> B& {
            return b.limit(quantity, min, max, ends ? Limit::Reaction::end : Limit::Reaction::flag);
          },
          py::arg("quantity"), py::arg("min") = -HUGE_VAL, py::arg("max") = HUGE_VAL, py::arg("ends") = true, self,
          "Limits of a measure or of a coordinate of a joint, rad or m. ends: the motion ends there; else an event "
          "reports it.")
      .def(
          "group",
          [](B& b, const std::string& name, const Names& unknowns, bool keep) -> B& {
            return b.add(DeclaredGroup{name, unknowns, keep});
          },
          py::arg("name"), py::arg("unknowns"), py::arg("keep") = false, self,
          "A structural group by the names of its points, vectors and scalars. keep: solve all of it.")
      .def(
          "output",
          [](B& b, const py::args& names) -> B& {
            for (const py::handle& name : names) b.output(name.cast<std::string>());
            return b;
          },
          self, "Adds outputs: 'C', 'C.velocity', 'C.vx', a measure, a body, or 'all' alone.")
      .def("time", &B::time, py::arg("start"), py::arg("end"), py::arg("step"), self, "The time grid, s.")
      .def(
          // Functions of the program are called, and may change the builder meanwhile: a copy is built.
          "build", [](const B& b) { return B(b).build(); },
          "Checks and returns the Scene; InputError has every finding.")
      .def("__repr__", [](const B&) { return std::string("SceneBuilder()"); });
}

}  // namespace assur::python
