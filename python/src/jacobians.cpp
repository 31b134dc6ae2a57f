// Jacobian matrices of a posture, and rows of a simulator for a function.
#include "module.hpp"

namespace assur::python {
namespace {

py::ssize_t size(std::size_t n) { return static_cast<py::ssize_t>(n); }

py::array indices(const std::vector<std::int32_t>& from) {
  return py::array_t<std::int32_t>(size(from.size()), from.data());
}

void add_classes(py::module_& m) {
  using Outputs = OutputJacobian;
  py::class_<Outputs>(m, "OutputJacobian", R"(Derivatives of outputs with respect to controlled drivers.)")
      .def_readonly("outputs", &Outputs::outputs,
                    "Names of the rows: 'C.x', or 'B.wx' of an angular velocity, whose row belongs to its rates.")
      .def_readonly("drivers", &Outputs::drivers, "Names of the columns.")
      .def_property_readonly(
          "values",
          [](const py::object& self) {
            const auto& j = self.cast<const Outputs&>();
            return view(j.values.data(), {size(j.outputs.size()), size(j.drivers.size())}, self);
          },
          "The matrix J with x' = J u': an array of (outputs, drivers), SI units; NaN if the status is not ok.")
      .def_readonly("smallest_singular_value", &Outputs::smallest_singular_value,
                    "In the unit of the values: compare it for outputs of one unit. NaN if J is empty.")
      .def_property_readonly(
          "status", [](const Outputs& j) { return object_of(j.status); }, "Status: 'ok', or 'singular'.")
      .def("__repr__", [](const Outputs& j) {
        return "OutputJacobian(" + plural(j.outputs.size(), "output") + ", " + plural(j.drivers.size(), "driver") + ")";
      });

  using Constraints = ConstraintJacobian;
  py::class_<Constraints>(m, "ConstraintJacobian", R"(Derivatives of the equations by their unknowns, sparse by columns.

scipy.sparse.csc_matrix((j.data, j.indices, j.indptr), j.shape) is the matrix.)")
      .def_readonly("equations", &Constraints::equations, "Names of the rows, which may repeat.")
      .def_readonly("unknowns", &Constraints::unknowns, "Names of the columns: 'C.x', ...")
      .def_property_readonly(
          "shape", [](const Constraints& j) { return std::make_pair(j.equations.size(), j.unknowns.size()); },
          "Number of equations, and of unknowns.")
      .def_property_readonly(
          "data", [](const Constraints& j) { return Array(size(j.values.size()), j.values.data()); },
          "The entries: an array of (entries,), by unknowns in SI units.")
      .def_property_readonly(
          "indices", [](const Constraints& j) { return indices(j.row); }, "Their rows: an array of (entries,).")
      .def_property_readonly(
          "indptr", [](const Constraints& j) { return indices(j.column_start); },
          "The first entry of each column, and the end: an array of (starts,), one more than there are unknowns.")
      .def("__repr__", [](const Constraints& j) {
        return "ConstraintJacobian(" + plural(j.equations.size(), "equation") + ", " +
               plural(j.unknowns.size(), "unknown") + ")";
      });
}

}  // namespace

void add_jacobians(py::module_& m) {
  add_classes(m);
  py::class_<Session>(m.attr("Simulator"))
      .def_property_readonly(
          "drivers", [](const Session& s) { return s.use()->drivers(); },
          "Names of the controlled drivers, and of each value of a controlled pose.")
      .def(
          "jacobian", [](const Session& s) { return s.call([](Simulator& of) { return of.jacobian(); }); },
          "The derivatives of the outputs with respect to the controlled drivers at the current posture: an "
          "OutputJacobian.")
      .def(
          "constraint_jacobian",
          [](const Session& s, std::optional<std::int32_t> group) {
            return s.call(
                [&](Simulator& of) { return group ? of.constraint_jacobian(*group) : of.constraint_jacobian(); });
          },
          py::arg("group") = py::none(),
          "The derivatives of the equations at the current posture: a ConstraintJacobian. group: number of a group, "
          "from 0; None: all, in solving order.")
      .def(
          "stream",
          [](const Session& session, const py::function& callback,
             const std::optional<std::vector<std::string>>& columns, std::size_t every, std::size_t block,
             const std::optional<Array>& times, const py::object& progress) {
            const Session::Use s = session.use();
            RowSelection selection;
            if (columns) selection.columns = *columns;
            selection.every = every;
            selection.block = block;
            const std::vector<double> at = times ? numbers(*times) : std::vector<double>();
            const RowSink sink = row_sink(callback, false);
            bool interrupted = false;
            const std::size_t rows = run_watched(progress, interrupted, [&](const Observer& observer) {
              return times ? s->stream(selection, sink, at, observer) : s->stream(selection, sink, observer);
            });
            if (interrupted) raise_interrupted(py::int_(rows));
            return rows;
          },
          py::arg("callback"), py::kw_only(), py::arg("columns") = py::none(), py::arg("every") = 1,
          py::arg("block") = 1024, py::arg("times") = py::none(), py::arg("progress") = py::none(),
          R"(Runs from the start posture, and calls callback(t, values) instead of keeping rows.

t: an array of (rows,), s. values: an array of (rows, columns), SI units, of these columns (None: all). every: every
n-th row. block: most rows of one call, up to 1024. times: None for the time grid of the scene. Returns the number of
rows that were reached; the report has the status.)");
}

}  // namespace assur::python
