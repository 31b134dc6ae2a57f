// Exceptions, statuses and reports.
#include "module.hpp"

namespace assur::python {
namespace {

std::string text_of(const Status& s) {
  std::string out = "Status('" + std::string(name(s.code)) + "'";
  const char* const kinds[] = {"", "driver", "group", "lane", "member", "target", "limit"};
  if (!s.where.is(Place::Kind::none)) {
    out += ", " + std::string(kinds[static_cast<std::size_t>(s.where.kind)]) + "=" + std::to_string(s.where.index);
  }
  if (s.figure != 0) out += ", figure=" + py::str(py::float_(s.figure)).cast<std::string>();
  return out + ")";
}

std::string text_of(const Report& r) {
  std::string out = "Report(" + text_of(r.status) + ", reached=" + py::str(py::float_(r.reached)).cast<std::string>() +
                    ", steps=" + std::to_string(r.counters.steps);
  const auto add = [&](const char* what, const py::object& figure) {
    if (!figure.is_none()) out += std::string(", ") + what + "=" + py::str("{:.1e}").format(figure).cast<std::string>();
  };
  add("residual", known(r.error.residual()));
  add("estimated_error", py::cast(r.error.estimated_position));
  if (!r.events.empty()) out += ", " + plural(r.events.size(), "event");
  if (!r.fallbacks.empty()) out += ", " + plural(r.fallbacks.size(), "fallback");
  return out + ")";
}

}  // namespace

void raise(const Error& e) {
  const char* const names[] = {"InputError", "NumericalError", "MachineError"};
  py::list diagnostics;
  for (const Diagnostic& d : e.diagnostics()) diagnostics.append(py::make_tuple(d.where, d.what));
  const py::object type = py::module_::import("assur._errors").attr(names[static_cast<std::size_t>(e.kind())]);
  PyErr_SetObject(type.ptr(), type(e.what(), diagnostics).ptr());
}

py::object known(double figure) { return std::isnan(figure) ? py::object(py::none()) : py::float_(figure); }

void add_errors(py::module_& m) {
  py::register_exception_translator([](std::exception_ptr p) {
    try {
      if (p) std::rethrow_exception(p);
    } catch (const Error& e) {
      raise(e);
    }
  });

  py::class_<Status>(m, "Status", R"(Outcome of a step or a run.)")
      .def_property_readonly(
          "code", [](const Status& s) { return std::string(name(s.code)); },
          "'ok', 'inaccurate', 'fold', ...: docs/accuracy.md explains each.")
      .def_property_readonly("ok", &Status::ok, "True if nothing is wrong.")
      .def_property_readonly("arrived", &Status::arrived,
                             "True if the time was reached, even if the result is 'inaccurate'.")
      .def_readonly("figure", &Status::figure,
                    "Size of what the status is about: an estimated error, a residual, a time in s; 0 if none.")
      .def_property_readonly(
          "index", [](const Status& s) { return s.where.index; },
          "Number of the object that the status is about, which Simulator.name_of() names; -1 if none.")
      .def("__bool__", &Status::arrived)
      .def(
          "__eq__", [](const Status& s, const std::string& code) { return name(s.code) == code; }, py::is_operator())
      .def(
          "__eq__",
          [](const Status& a, const Status& b) {
            return a.code == b.code && a.where == b.where &&
                   (a.figure == b.figure || (a.figure != a.figure && b.figure != b.figure));
          },
          py::is_operator())
      .def("__repr__", [](const Status& s) { return text_of(s); });

  py::class_<Event>(m, "Event", R"(Something that happened at a time: a fold, a change point, a doubt, a limit.)")
      .def_readonly("time", &Event::time, "s; the begin, if the time is known to lie in an interval.")
      .def_readonly("until", &Event::until, "End of that interval, s.")
      .def_readonly("group", &Event::group, "Name of the group, driver, constraint or quantity; '' if none.")
      .def_property_readonly(
          "kind", [](const Event& e) { return std::string(name(e.kind)); }, "As Status.code.")
      .def_readonly("figure", &Event::figure, "As Status.figure; of a limit its bound, in SI units.")
      .def_readonly("detail", &Event::detail, "Further explanation, or ''.")
      .def_readonly("unit", &Event::unit, "Unit of the figure, or ''.")
      .def("__repr__", [](const Event& e) {
        return py::str("Event('{}', time={:.6g}, group='{}')")
            .format(std::string(name(e.kind)), e.time, e.group)
            .cast<std::string>();
      });

  py::class_<Report>(m, "Report", R"(Work, errors, events and status of a run, or of single steps.)")
      .def_readonly("status", &Report::status, "Status of the run: that of its first failure or doubt.")
      .def_readonly("reached", &Report::reached, "Last time with a valid posture, s.")
      .def_readonly("events", &Report::events, "List of Event, in the order in which they were noticed.")
      .def_readonly("fallbacks", &Report::fallbacks, "Deviations from the plan, with their reasons.")
      .def_readonly("dropped_events", &Report::dropped_events, "Events that single steps dropped.")
      .def_property_readonly(
          "residuals",
          [](const Report& r) {
            py::dict out;
            out["position"] = known(r.error.position);
            out["velocity"] = known(r.error.velocity);
            out["acceleration"] = known(r.error.acceleration);
            return out;
          },
          "Largest relative residuals; None if not measured.")
      .def_property_readonly(
          "estimated_errors",
          [](const Report& r) {
            py::dict out;
            out["position"] = r.error.estimated_position;
            out["velocity"] = r.error.estimated_velocity;
            out["acceleration"] = r.error.estimated_acceleration;
            return out;
          },
          "Estimated relative errors of the outputs; None if there is no such output.")
      .def_property_readonly(
          "counters",
          [](const Report& r) {
            const Counters& c = r.counters;
            py::dict out;
            out["steps"] = c.steps;
            out["substeps"] = c.substeps;
            out["rejected"] = c.rejected;
            out["group_solutions"] = c.group_solutions;
            out["newton_iterations"] = c.newton_iterations;
            out["most_iterations"] = c.most_iterations;
            out["factorizations"] = c.factorizations;
            return out;
          },
          "Counted work: steps, substeps, rejected, group_solutions, newton_iterations, ...")
      .def("__repr__", [](const Report& r) { return text_of(r); });
}

}  // namespace assur::python
