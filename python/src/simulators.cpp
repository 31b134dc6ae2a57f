// Simulators and trajectories.
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <filesystem>

#include "module.hpp"
#include "pictures/quantities.hpp"

namespace assur::python {
namespace {

using Path = std::filesystem::path;

std::map<std::string, std::string> units_of(const Structure& structure, const std::vector<std::string>& columns) {
  std::map<std::string, std::string> out;
  for (const pictures::Quantity& q : pictures::quantities(structure)) {
    for (const std::size_t c : q.columns) out[columns[c]] = q.unit;
  }
  return out;
}

// Shows the columns of a trajectory, under their names.
py::array column_of(const py::object& self, const std::string& column) {
  const auto& t = self.cast<const Motions&>();
  const auto width = static_cast<py::ssize_t>(t.columns().size() * sizeof(double));
  return view(t.values().data() + t.index(column), {static_cast<py::ssize_t>(t.rows())}, self, {width});
}

StepSettings settings_of(int iterations, int most_iterations, double seconds, const std::vector<int>& pin_to) {
  StepSettings out;
  out.iterations = iterations;
  out.most_iterations = most_iterations;
  out.seconds = seconds;
  out.pin_to = pin_to;
  return out;
}

std::size_t check_index(const Simulator& s, std::size_t column) {
  if (column < s.columns().size()) return column;
  throw py::index_error("there are " + plural(s.columns().size(), "output") + ", and no number " +
                        std::to_string(column));
}

}  // namespace

py::object object_of(const Status& status) {
  static const auto* const kOk = new py::object(py::cast(Status()));
  return status.ok() && status.figure == 0 ? *kOk : py::cast(status);
}

Session::Session(const Ready& prepared, const StepSettings& settings)
    : Exclusive(with_threads(prepared.plan(), [&] { return std::make_unique<Simulator>(prepared, settings); }),
                "simulator", prepared.name()),
      modes(prepared.modes) {}

void add_simulators(py::module_& m) {
  py::class_<Motions>(m, "Trajectory", R"(The rows of a run, in SI units. motion['C.x'] is a column.

Arrays show the memory of the trajectory: nothing is copied, and they cannot be written.)")
      .def_property_readonly("columns", &Trajectory::columns, "Names of the outputs: 'C.x', 'C.vx', 'angle.rate', ...")
      .def_property_readonly(
          "t",
          [](const py::object& self) {
            const auto& t = self.cast<const Motions&>();
            return view(t.times().data(), {static_cast<py::ssize_t>(t.rows())}, self);
          },
          "Times of the rows, s: an array of (rows,).")
      .def_property_readonly(
          "values",
          [](const py::object& self) {
            const auto& t = self.cast<const Motions&>();
            return view(t.values().data(),
                        {static_cast<py::ssize_t>(t.rows()), static_cast<py::ssize_t>(t.columns().size())}, self);
          },
          "All outputs: an array of (rows, columns), SI units.")
      .def("__getitem__", &column_of, py::arg("column"), "One output over time: an array of (rows,).")
      .def("__len__", &Trajectory::rows)
      .def("__iter__", [](const Motions& t) { return py::iter(py::cast(t.columns())); })
      .def("__contains__",
           [](const Motions& t, const std::string& column) {
             return std::find(t.columns().begin(), t.columns().end(), column) != t.columns().end();
           })
      .def("keys", &Trajectory::columns, "Names of the outputs.")
      .def(
          "write_csv",
          [](const Motions& t, const Path& file) { write_file(file, [&](std::ostream& out) { write_csv(out, t); }); },
          py::arg("file"), "Writes a CSV with the columns t and all outputs, every digit kept; s and SI units.")
      .def(
          "write_npy",
          [](const Motions& t, const Path& file, std::size_t every, bool single) {
            write_file(file, [&](std::ostream& out) { write_npy(out, t, {every, single}); });
          },
          py::arg("file"), py::arg("every") = 1, py::arg("single") = false,
          "Writes every n-th row for numpy.load(): an array of (rows,) with the fields t and all outputs. single: in "
          "single precision.")
      .def_property_readonly(
          "prepared", [](const Motions& t) { return *t.of; }, "The Prepared that moved; its `scene` is the scene.")
      .def_readonly("report", &Motions::report, "The Report of the run: its status tells why the motion ended.")
      .def_property_readonly(
          "status", [](const Motions& t) { return object_of(t.report.status); },
          "Status of the run: 'ok', 'inaccurate', or the reason why the motion ended early.")
      .def_property_readonly(
          "units", [](const Motions& t) { return units_of(t.of->structure(), t.columns()); },
          "Units of the columns: a dict of names and texts such as 'm/s'; '': none.")
      .def("__repr__", [](const Motions& t) {
        std::string out = "Trajectory(" + plural(t.rows(), "row") + " of " + plural(t.columns().size(), "column");
        if (t.rows() > 0) {
          out += ", t = " + py::str("{:g} to {:g} s").format(t.times().front(), t.times().back()).cast<std::string>();
        }
        if (!t.report.status.ok()) out += ", status '" + std::string(name(t.report.status.code)) + "'";
        return out + ")";
      });

  py::class_<DriverHandle>(m, "DriverHandle", R"(A controlled driver, found once by Simulator.driver().)");
  py::class_<SimulatorState>(m, "SimulatorState", R"(A saved state of a simulator: Simulator.save(), restore().)")
      .def_property_readonly("time", &SimulatorState::time, "Time of the posture, s.");

  py::class_<Session> simulator(m, "Simulator", R"(Moves one mechanism, step by step or over its time grid.

A simulator serves one thread at a time; different simulators run in different threads. `with` closes it at the end.)");
  simulator
      .def(py::init([](const py::object& of, int iterations, int most_iterations, double seconds,
                       const std::vector<int>& pin_to) {
             const StepSettings settings = settings_of(iterations, most_iterations, seconds, pin_to);
             if (py::isinstance<Scene>(of)) return Session({prepare(of.cast<const Scene&>()), {}}, settings);
             if (py::isinstance<Ready>(of)) return Session(of.cast<const Ready&>(), settings);
             throw py::type_error("a Simulator needs a Prepared or a Scene, not " + py::repr(of).cast<std::string>() +
                                  "; assur.scene() opens files and samples");
           }),
           py::arg("prepared"), py::kw_only(), py::arg("iterations") = 0, py::arg("most_iterations") = 12,
           py::arg("seconds") = 0., py::arg("pin_to") = std::vector<int>{},
           R"(Begins at the start posture of a Prepared (or of a Scene, which is prepared with default options).

iterations: a fixed number of Newton iterations (0: until they converge). most_iterations: a step is divided if it needs
more. seconds: time limit of one step, s; 0: none. pin_to: processors for the threads.)")
      .def_property_readonly(
          "time", [](const Session& s) { return s.use()->time(); }, "Time of the current posture, s.")
      // set(), step() and output() are documented in control_loops.cpp.
      .def("step", [](const Session& s) { return object_of(s.call([](Simulator& of) { return of.step(); })); })
      .def(
          "step",
          [](const Session& s, double t) { return object_of(s.call([t](Simulator& of) { return of.step(t); })); },
          py::arg("t"))
      .def(
          "set",
          [](const Session& s, DriverHandle driver, double value, double rate, double acceleration) {
            s.use()->set(driver, value, rate, acceleration);
          },
          py::arg("driver"), py::arg("value"), py::arg("rate") = 0., py::arg("acceleration") = 0.)
      .def(
          "set",
          [](const Session& s, const std::string& driver, double value, double rate, double acceleration) {
            s.use()->set(driver, value, rate, acceleration);
          },
          py::arg("driver"), py::arg("value"), py::arg("rate") = 0., py::arg("acceleration") = 0.)
      .def(
          "driver", [](const Session& s, const std::string& name) { return s.use()->driver(name); }, py::arg("name"),
          "The handle of a controlled driver, for control loops.")
      .def(
          "index", [](const Session& s, const std::string& column) { return s.use()->index(column); },
          py::arg("column"), "Index of a column in outputs, for control loops.")
      .def(
          "output",
          [](const Session& session, std::size_t column) {
            const Session::Use s = session.use();
            return s->outputs()[check_index(*s, column)];
          },
          py::arg("column"))
      .def(
          "output", [](const Session& s, const std::string& column) { return s.use()->output(column); },
          py::arg("column"), "One output at the current time, by its name or by index(); SI units.")
      .def(
          "name_of", [](const Session& s, const Status& status) { return s.use()->name_of(status.where); },
          py::arg("status"),
          "Name of the driver, group or limited quantity that a status of this simulator is about; '' if none.")
      .def_property_readonly(
          "columns", [](const Session& s) { return s.use()->columns(); }, "Names of the outputs.")
      .def_property_readonly(
          "outputs",
          [](const Session& s) {
            const std::span<const double> row = s.use()->outputs();
            const py::capsule keep(new std::shared_ptr<Simulator>(s.shared()),
                                   [](void* p) { delete static_cast<std::shared_ptr<Simulator>*>(p); });
            return view(row.data(), {static_cast<py::ssize_t>(row.size())}, keep);
          },
          "All outputs at the current time, SI units: an array of (columns,) that shows the memory of the simulator, "
          "and so "
          "changes with each step.")
      .def(
          "run",
          [](const Session& session, const std::optional<Array>& times, const py::object& progress) {
            const Session::Use s = session.use();
            const std::vector<double> at = times ? numbers(*times) : std::vector<double>();
            bool interrupted = false;
            Trajectory rows = run_watched(progress, interrupted, [&](const Observer& observer) {
              return times ? s->run(at, observer) : s->run(observer);
            });
            py::object out = py::cast(Motions{
                std::move(rows), std::make_shared<const Ready>(Ready{s->prepared(), session.modes}), s->report()});
            if (interrupted) raise_interrupted(out);
            return out;
          },
          py::arg("times") = py::none(), py::kw_only(), py::arg("progress") = py::none(),
          R"(Runs from the start posture over the time grid of the scene, or over `times`, an array
of (times,), s, ascending.

Returns a Trajectory with the rows that were reached; its status tells why it ended. Other threads of Python go on
meanwhile. Ctrl-C raises Interrupted, whose `result` has the rows that were done. progress: tqdm, or a bar of it.)")
      .def(
          "reset", [](const Session& s) { s.call([](Simulator& of) { of.reset(); }); },
          "Returns to the start posture; clears report and targets.")
      .def(
          "retreat", [](const Session& s) { s.call([](Simulator& of) { of.retreat(); }); },
          "Returns to the last posture that an undivided step reached: after step(t) failed near a limit.")
      .def(
          "save", [](const Session& s) { return s.use()->save(); }, "Saves the state, to which restore() returns.")
      .def(
          "restore",
          [](const Session& s, const SimulatorState& state) { s.call([&](Simulator& of) { of.restore(state); }); },
          py::arg("state"), "Returns to a saved state.")
      .def_property_readonly(
          "report", [](const Session& s) { return s.use()->report(); },
          "Report since the begin of the run, or of the single steps.")
      .def_property_readonly(
          "prepared",
          [](const Session& s) {
            return Ready{s.use()->prepared(), s.modes};
          },
          "Plan and structure in use.")
      .def(
          "examine",
          [](const Session& session) {
            std::vector<Group> groups;
            const std::vector<GroupFigures> figures = session.call([&](Simulator& s) {
              groups = s.prepared().structure().groups();
              return s.examine();
            });
            py::dict out;
            for (const GroupFigures& f : figures) {
              py::dict of;
              of["residual"] = f.residual;
              of["condition"] = f.condition;
              of["estimated_error"] = f.estimated_error;
              out[py::str(groups[static_cast<std::size_t>(f.group)].name)] = of;
            }
            return out;
          },
          "Accuracy of each group at the current posture: a dict of groups, each a dict of 'residual', 'condition' and "
          "'estimated_error', relative to the characteristic length.")
      .def(
          "close", [](Session& s) { s.close(); },
          "Ends threads and returns memory; any later use raises InputError. Arrays of it stay valid.")
      .def("__enter__", [](const py::object& self) { return self; })
      .def("__exit__", [](Session& s, const py::args&) { s.close(); })
      .def("__repr__", [](const Session& session) {
        if (*session.state() != 0) return "Simulator(" + std::string(session.state()) + ")";
        const Session::Use s = session.use();
        return py::str("Simulator('{}', time={:g} s, {})")
            .format(s->prepared().name(), s->time(), plural(s->columns().size(), "output"))
            .cast<std::string>();
      });
}

}  // namespace assur::python
