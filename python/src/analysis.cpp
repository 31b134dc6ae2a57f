// Assembly modes, ranges of drivers, and proofs and references for a motion.
#include "module.hpp"

namespace assur::python {
namespace {

// Values for people: {'C.x': 1.5, ...}.
std::map<std::string, double> named(const std::vector<std::string>& names, const std::vector<double>& values) {
  std::map<std::string, double> out;
  for (std::size_t i = 0; i < names.size(); ++i) out[names[i]] = values[i];
  return out;
}

py::array_t<double> table(const std::vector<std::vector<double>>& rows, std::size_t columns) {
  py::array_t<double> out({static_cast<py::ssize_t>(rows.size()), static_cast<py::ssize_t>(columns)});
  double* to = out.mutable_data();
  for (const std::vector<double>& row : rows) to = std::copy(row.begin(), row.end(), to);
  return out;
}

void add_modes(py::module_& m) {
  using Modes = AssemblyModes;
  py::class_<Modes>(m, "AssemblyModes", R"(All postures of one group, with the groups before it at their start.)")
      .def_readonly("group", &Modes::group, "Name of the group.")
      .def_readonly("unknowns", &Modes::unknowns, "Names of the unknowns: 'C.x', ...")
      .def_property_readonly(
          "values",
          [](const Modes& modes) {
            std::vector<std::vector<double>> rows;
            for (const AssemblyMode& mode : modes.modes) rows.push_back(mode.values);
            return table(rows, modes.unknowns.size());
          },
          "The modes: an array of (modes, unknowns), SI units. The start posture comes first, if has_start.")
      .def_property_readonly(
          "conditions",
          [](const Modes& modes) {
            std::vector<double> out;
            for (const AssemblyMode& mode : modes.modes) out.push_back(mode.condition);
            return out;
          },
          "Condition number of each mode, without unit; large if two modes nearly meet.")
      .def_property_readonly(
          "folds", [](const Modes& modes) { return table(modes.folds, modes.unknowns.size()); },
          "Multiple solutions, which are no modes: an array of (folds, unknowns), SI units.")
      .def_readonly("has_start", &Modes::has_start, "False: the start posture cannot be assembled.")
      .def_readonly("why_none", &Modes::why_none, "Why the modes were not computed; '': they were.")
      .def_property_readonly("complete", &Modes::complete, "True if no mode is missing.")
      .def(
          "nearest",
          [](const Modes& modes, const std::string& point, const std::vector<double>& at) {
            if (at.size() != 2 && at.size() != 3) throw Error(Error::Kind::input, "a place has 2 or 3 numbers");
            return modes.nearest(point, {at[0], at[1], at.size() == 3 ? at[2] : 0});
          },
          py::arg("point"), py::arg("at"), "Number of the mode in which a point is nearest to `at`: (x, y, z), m.")
      .def("__len__", [](const Modes& modes) { return modes.modes.size(); })
      .def("__getitem__",
           [](const Modes& modes, std::size_t k) {
             if (k >= modes.modes.size()) throw py::index_error("there are " + plural(modes.modes.size(), "mode"));
             return named(modes.unknowns, modes.modes[k].values);
           })
      .def("__repr__", [](const Modes& modes) {
        return "AssemblyModes('" + modes.group + "', " + plural(modes.modes.size(), "mode") + ")";
      });
  m.def(
      "assembly_modes",
      [](const Scene& scene, const std::map<std::string, std::size_t>& chosen) {
        const py::gil_scoped_release release;
        return assembly_modes(scene, choices_of(chosen));
      },
      py::arg("scene"), py::arg("chosen") = std::map<std::string, std::size_t>{},
      R"(All postures of each group at the start: a list of AssemblyModes, in solving order.

chosen: a dict of groups (or of points that they solve) and numbers of their modes, in which later groups are solved.
prepare() takes such a dict as `modes`.)");
}

void add_range(py::module_& m) {
  py::class_<RangeEnd>(m, "RangeEnd", R"(One end of the range of a driver, in the unit of the range.)")
      .def_property_readonly(
          "code", [](const RangeEnd& e) { return std::string(name(e.code)); },
          "'fold': a fold; 'limit_reached': a limit of the scene; 'ok': no end was found; or a failure.")
      .def_readonly("reached", &RangeEnd::reached, "A value that the mechanism reaches, rad or m.")
      .def_readonly("beyond", &RangeEnd::beyond,
                    "A value that it does not reach, rad or m; without an end as `reached`.")
      .def_readonly("group", &RangeEnd::group, "The group at its fold, or the quantity at its limit; '': none.")
      .def("__repr__", [](const RangeEnd& e) {
        return py::str("RangeEnd('{}', {:.10g})").format(std::string(name(e.code)), e.reached).cast<std::string>();
      });
  py::class_<MotionRange>(m, "MotionRange", R"(How far one driver moves from the start posture, both ways.)")
      .def_readonly("driver", &MotionRange::driver, "Name of the driver.")
      .def_readonly("unit", &MotionRange::unit, "'rad', 'm', or ''.")
      .def_readonly("start", &MotionRange::start, "Value in the start posture, rad or m.")
      .def_readonly("low", &MotionRange::low, "The end below it.")
      .def_readonly("high", &MotionRange::high, "The end above it.")
      .def_readonly("change_points", &MotionRange::change_points,
                    "Values at which branches cross, and the motion went straight on, rad or m.")
      .def_property_readonly(
          "passed",
          [](const MotionRange& r) {
            std::vector<std::tuple<std::string, double, bool>> out;
            for (const PassedLimit& p : r.passed) out.emplace_back(p.quantity, p.at, p.leaves);
            return out;
          },
          "Limits that only flag: (quantity, value of the driver in rad or m, True if the quantity leaves its limit).")
      .def("__repr__", [](const MotionRange& r) {
        return py::str("MotionRange('{}', {:.10g} to {:.10g} {})")
            .format(r.driver, r.low.reached, r.high.reached, r.unit)
            .cast<std::string>();
      });
  m.def(
      "motion_range",
      [](const Scene& scene, const std::string& driver, double farthest) {
        const py::gil_scoped_release release;
        return motion_range(scene, driver, farthest);
      },
      py::arg("scene"), py::arg("driver") = "", py::arg("farthest") = 0.,
      R"(Moves one driver both ways from the start posture until the motion ends; returns a MotionRange.

driver: a name; '': the only one. farthest: the longest way, rad or m; 0: one turn, or ten lengths of a part.)");
}

void add_certificates(py::module_& m) {
  py::class_<Certificate>(m, "Certificate", R"(A proof about one computed posture (docs/accuracy.md).

There is exactly one true posture within `uniqueness` of it, and it is at most `radius` away. Both are relative to the
characteristic length of the mechanism.)")
      .def_readonly("time", &Certificate::time, "Time of the posture, s.")
      .def_readonly("radius", &Certificate::radius, "Bound of the error of each unknown, relative; inf: not proven.")
      .def_readonly("uniqueness", &Certificate::uniqueness, "Radius with one solution only, relative.")
      .def_readonly("group", &Certificate::group, "The group with the largest radius, or without a proof.")
      .def_readonly("why_not", &Certificate::why_not, "Why nothing is proven; '': proven.")
      .def("__repr__", [](const Certificate& c) {
        return py::str("Certificate(time={:g} s, radius={:.2g})").format(c.time, c.radius).cast<std::string>();
      });
  m.def(
      "certify",
      [](const Session& session) {
        const Session::Use simulator = session.use();
        const py::gil_scoped_release release;
        return certify(*simulator);
      },
      py::arg("simulator"));
  m.def(
      "certify",
      [](const Motions& motion) {
        const py::gil_scoped_release release;
        return certify(static_cast<const Prepared&>(*motion.of), motion);
      },
      py::arg("motion"),
      R"(Proves the current posture of a Simulator, or each row of a Trajectory (a list). Returns Certificates.

Rows that were computed in chunks, or with other limits than those of Simulator(prepared), get no proof. Raises
InputError for a loaded plan.)");
  m.def(
      "worst_of", [](const std::vector<Certificate>& all) { return worst_of(all); }, py::arg("certificates"),
      "The weakest of several proofs: the Certificate with the largest radius, and the smallest uniqueness of all.");
  m.def(
      "forward_error",
      [](const Motions& motion) {
        const ForwardError e = [&] {
          const py::gil_scoped_release release;
          return forward_error(*motion.of, motion);
        }();
        py::dict out;
        out["position"] = known(e.position);
        out["velocity"] = known(e.velocity);
        out["acceleration"] = known(e.acceleration);
        return out;
      },
      py::arg("motion"),
      R"(True errors of a Trajectory, against a reference in quadruple precision: a dict of 'position', 'velocity' and
'acceleration', relative to the largest value of each output; None if there is no such output.)");
}

}  // namespace

void add_analysis(py::module_& m) {
  add_modes(m);
  add_range(m);
  add_certificates(m);
}

}  // namespace assur::python
