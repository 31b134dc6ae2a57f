// Simulators and trajectories.
#include <algorithm>
#include <fstream>

#include "module.hpp"

namespace assur::python {
namespace {

// Shows the columns of a trajectory, under their names.
py::array column_of(const py::object& self, const std::string& column) {
  const auto& t = self.cast<const Trajectory&>();
  const auto width = static_cast<py::ssize_t>(t.columns().size() * sizeof(double));
  return view(t.values().data() + t.index(column), {static_cast<py::ssize_t>(t.rows())}, self, {width});
}

StepLimits limits_of(int iterations, int most_iterations, double seconds, const std::vector<int>& pin_to) {
  StepLimits out;
  out.iterations = iterations;
  out.most_iterations = most_iterations;
  out.seconds = seconds;
  out.pin_to = pin_to;
  return out;
}

// Success is one object: making another one takes as long as a short step.
py::object status_of(const Status& status) {
  static const auto* const kOk = new py::object(py::cast(Status()));
  return status.ok() && status.figure == 0 ? *kOk : py::cast(status);
}

std::size_t check_index(const Simulator& s, std::size_t column) {
  if (column < s.columns().size()) return column;
  throw py::index_error("there are " + plural(s.columns().size(), "output") + ", and no number " +
                        std::to_string(column));
}

}  // namespace

void add_simulators(py::module_& m) {
  py::class_<Trajectory>(m, "Trajectory", R"(The rows of a run, in SI units. motion['C.x'] is a column.

Arrays show the memory of the trajectory: nothing is copied, and they cannot be written.)")
      .def_property_readonly("columns", &Trajectory::columns, "Names of the outputs: 'C.x', 'C.vx', 'angle.rate', ...")
      .def_property_readonly(
          "t",
          [](const py::object& self) {
            const auto& t = self.cast<const Trajectory&>();
            return view(t.times().data(), {static_cast<py::ssize_t>(t.rows())}, self);
          },
          "Times of the rows, s: an array of (rows,).")
      .def_property_readonly(
          "values",
          [](const py::object& self) {
            const auto& t = self.cast<const Trajectory&>();
            return view(t.values().data(),
                        {static_cast<py::ssize_t>(t.rows()), static_cast<py::ssize_t>(t.columns().size())}, self);
          },
          "All outputs: an array of (rows, columns).")
      .def("__getitem__", &column_of, py::arg("column"), "One output over time: an array of (rows,).")
      .def("__len__", &Trajectory::rows)
      .def("__contains__",
           [](const Trajectory& t, const std::string& column) {
             return std::find(t.columns().begin(), t.columns().end(), column) != t.columns().end();
           })
      .def("keys", &Trajectory::columns, "Names of the outputs.")
      .def(
          "write_csv",
          [](const Trajectory& t, const std::string& file) {
            std::ofstream out(file);
            write_csv(out, t);
            out.flush();
            if (!out) throw Error(Error::Kind::environment, file + " cannot be written");
          },
          py::arg("file"), "Writes a CSV with the columns t and all outputs, every digit kept.")
      .def("__repr__", [](const Trajectory& t) {
        std::string out = "Trajectory(" + plural(t.rows(), "row") + " of " + plural(t.columns().size(), "column");
        if (t.rows() > 0) {
          out += ", t = " + py::str("{:g} to {:g} s").format(t.times().front(), t.times().back()).cast<std::string>();
        }
        return out + ")";
      });

  py::class_<DriverHandle>(m, "DriverHandle", R"(A controlled driver, found once by Simulator.driver().)");
  py::class_<SimulatorState>(m, "SimulatorState", R"(A saved state of a simulator: Simulator.save(), restore().)")
      .def_property_readonly("time", &SimulatorState::time, "Time of the posture, s.");

  py::class_<Simulator>(m, "Simulator", R"(Moves one mechanism, step by step or over its time grid.

A simulator serves one thread at a time; different simulators run in different threads.)")
      .def(py::init([](const py::object& of, int iterations, int most_iterations, double seconds,
                       const std::vector<int>& pin_to) {
             const Prepared prepared =
                 py::isinstance<Scene>(of) ? prepare(of.cast<const Scene&>()) : of.cast<const Prepared&>();
             return Simulator(prepared, limits_of(iterations, most_iterations, seconds, pin_to));
           }),
           py::arg("prepared"), py::kw_only(), py::arg("iterations") = 0, py::arg("most_iterations") = 12,
           py::arg("seconds") = 0., py::arg("pin_to") = std::vector<int>{},
           R"(Begins at the start posture of a Prepared (or of a Scene, which is prepared with default options).

iterations: a fixed number of Newton iterations (0: until they converge). most_iterations: a step is divided if it needs
more. seconds: time limit of one step; 0: none. pin_to: processors for the threads.)")
      .def_property_readonly("time", &Simulator::time, "Time of the current posture, s.")
      .def(
          "step", [](Simulator& s) { return status_of(s.step()); },
          "Moves by one step of the time grid to the targets that were set.")
      .def(
          "step", [](Simulator& s, double t) { return status_of(s.step(t)); }, py::arg("t"),
          R"(Moves to the time t (s).

Returns a Status, which is true if the time was reached. If it fails, step() returns to the state before it, and step(t)
stays at the last good posture.)")
      .def(
          "set",
          [](Simulator& s, DriverHandle driver, double value, double rate, double acceleration) {
            s.set(driver, value, rate, acceleration);
          },
          py::arg("driver"), py::arg("value"), py::arg("rate") = 0., py::arg("acceleration") = 0.)
      .def(
          "set",
          [](Simulator& s, const std::string& driver, double value, double rate, double acceleration) {
            s.set(driver, value, rate, acceleration);
          },
          py::arg("driver"), py::arg("value"), py::arg("rate") = 0., py::arg("acceleration") = 0.,
          "Sets the target of a controlled driver (a name, or a handle of driver()) for the next step; SI units.")
      .def("driver", &Simulator::driver, py::arg("name"), "The handle of a controlled driver, for control loops.")
      .def("index", &Simulator::index, py::arg("column"), "Index of a column in outputs, for control loops.")
      .def(
          "output", [](const Simulator& s, std::size_t column) { return s.outputs()[check_index(s, column)]; },
          py::arg("column"))
      .def(
          "output", [](const Simulator& s, const std::string& column) { return s.output(column); }, py::arg("column"),
          "One output at the current time, by its name or by index(); SI units.")
      .def_property_readonly("columns", &Simulator::columns, "Names of the outputs.")
      .def_property_readonly(
          "outputs",
          [](const py::object& self) {
            const std::span<const double> row = self.cast<const Simulator&>().outputs();
            return view(row.data(), {static_cast<py::ssize_t>(row.size())}, self);
          },
          "All outputs at the current time: an array of (columns,) that shows the memory of the simulator, and so "
          "changes with each step.")
      .def(
          "run",
          [](Simulator& s, const std::optional<Array>& times, const py::object& progress) {
            const std::vector<double> at = times ? numbers(*times) : std::vector<double>();
            bool interrupted = false;
            py::object out = py::cast(run_watched(progress, interrupted, [&](const Simulator::Observer& observer) {
              return times ? s.run(at, observer) : s.run(observer);
            }));
            if (interrupted) raise_interrupted(out);
            return out;
          },
          py::arg("times") = py::none(), py::kw_only(), py::arg("progress") = py::none(),
          R"(Runs from the start posture over the time grid of the scene, or over `times` (s, ascending).

Returns a Trajectory with the rows that were reached; report.status tells why it ended. Other threads of Python go on
meanwhile. Ctrl-C raises Interrupted, whose `result` has the rows that were done. progress: tqdm, or a bar of it.)")
      .def("reset", &Simulator::reset, "Returns to the start posture; clears report and targets.")
      .def(
          "save", [](Simulator& s) { return s.save(); }, "Saves the state, to which restore() returns.")
      .def("restore", &Simulator::restore, py::arg("state"), "Returns to a saved state.")
      .def_property_readonly(
          "report", [](const Simulator& s) { return s.report(); },
          "Report since the begin of the run, or of the single steps.")
      .def_property_readonly(
          "prepared", [](const Simulator& s) { return s.prepared(); }, "Plan and structure in use.")
      .def("__repr__", [](const Simulator& s) {
        return py::str("Simulator('{}', time={:g} s, {})")
            .format(s.prepared().name, s.time(), plural(s.columns().size(), "output"))
            .cast<std::string>();
      });
}

}  // namespace assur::python
