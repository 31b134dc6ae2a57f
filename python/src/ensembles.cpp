// Ensembles: many variants at once.
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <filesystem>

#include "module.hpp"

namespace assur::python {
namespace {

struct Table {
  std::vector<std::string> names;
  std::vector<double> values;  // members x names
};

// Columns of a table, each of (members,); one number stands for a column of it.
Table table_of(const py::dict& columns) {
  Table out;
  std::vector<Array> arrays;
  py::ssize_t members = 1;
  for (const auto& [name, column] : columns) {
    out.names.push_back(name.cast<std::string>());
    arrays.push_back(column.cast<Array>());
    if (arrays.back().ndim() > 1) {
      throw Error(Error::Kind::input,
                  "the values of '" + out.names.back() + "' must be one number or one for each member");
    }
    if (arrays.back().ndim() == 0 || arrays.back().size() == members) continue;
    if (members != 1) {
      throw Error(Error::Kind::input, "'" + out.names.back() + "' has " +
                                          plural(static_cast<std::size_t>(arrays.back().size()), "value") +
                                          ", but other columns have " + std::to_string(members));
    }
    members = arrays.back().size();
  }
  if (arrays.empty()) throw Error(Error::Kind::input, "an ensemble needs at least one name with values");
  out.values.resize(static_cast<std::size_t>(members) * arrays.size());
  for (std::size_t k = 0; k < arrays.size(); ++k) {
    const double* const from = arrays[k].data();
    const bool same = arrays[k].size() == 1;
    for (std::size_t i = 0; i < static_cast<std::size_t>(members); ++i) {
      out.values[i * arrays.size() + k] = from[same ? 0 : i];
    }
  }
  return out;
}

using Path = std::filesystem::path;
using Names = std::vector<std::string>;

// An ensemble with the names of its table.
struct TableEnsemble : Exclusive<Ensemble> {
  Names names;

  void bind(const py::dict& columns) const {
    Table table = table_of(columns);
    std::vector<std::size_t> place;
    for (const std::string& name : names) {
      const auto at = std::find(table.names.begin(), table.names.end(), name);
      if (at == table.names.end() || table.names.size() != names.size()) {
        throw Error(Error::Kind::input, "bind() needs values of the names with which the ensemble was made");
      }
      place.push_back(static_cast<std::size_t>(at - table.names.begin()));
    }
    std::vector<double> values(table.values.size());
    for (std::size_t i = 0; i < values.size(); i += names.size()) {
      for (std::size_t k = 0; k < names.size(); ++k) values[i + k] = table.values[i + place[k]];
    }
    use()->bind(std::move(values));
  }
};

// Calls run(ensemble, times, observer), or run(ensemble, observer) for the time grid of the scene, without the lock of
// the interpreter.
template <class Run>
auto run_members(const TableEnsemble& e, const std::optional<Array>& times, const py::object& progress,
                 bool& interrupted, const Run& run) {
  const TableEnsemble::Use ensemble = e.use();
  const std::vector<double> at = times ? numbers(*times) : std::vector<double>();
  return run_watched(progress, interrupted, [&](const Observer& observer) {
    return times ? run(*ensemble, std::span(at), observer) : run(*ensemble, observer);
  });
}

py::ssize_t size(std::size_t n) { return static_cast<py::ssize_t>(n); }

}  // namespace

RowSink row_sink(const py::function& callback, bool with_member) {
  return [callback = shared(callback), with_member](const MemberRows& rows) {
    const py::gil_scoped_acquire lock;
    const auto count = static_cast<py::ssize_t>(rows.times.size());
    const py::ssize_t columns = static_cast<py::ssize_t>(rows.values.size()) / count;
    const Array times(count, rows.times.data()), values({count, columns}, rows.values.data());
    with_member ? (*callback)(rows.member, times, values) : (*callback)(times, values);
  };
}

void add_ensembles(py::module_& m) {
  py::class_<EnsembleTrajectory>(m, "EnsembleTrajectory", R"(The rows of all members of an ensemble, in SI units.

motion['C.x'] is an array of (members, times). Rows that a member did not reach are NaN. Arrays show the memory of the
result: nothing is copied, and they cannot be written.)")
      .def_property_readonly("columns", &EnsembleTrajectory::columns, "Names of the outputs.")
      .def_property_readonly(
          "t",
          [](const py::object& self) {
            const auto& e = self.cast<const EnsembleTrajectory&>();
            return view(e.times().data(), {size(e.times().size())}, self);
          },
          "Times of the rows, s: an array of (times,).")
      .def_property_readonly(
          "values",
          [](const py::object& self) {
            const auto& e = self.cast<const EnsembleTrajectory&>();
            return view(e.values().data(), {size(e.members()), size(e.times().size()), size(e.columns().size())}, self);
          },
          "All outputs: an array of (members, times, columns), SI units.")
      .def_property_readonly(
          "rows",
          [](const EnsembleTrajectory& e) {
            py::array_t<std::int64_t> out(size(e.members()));
            for (std::size_t i = 0; i < e.members(); ++i) out.mutable_at(i) = static_cast<std::int64_t>(e.rows(i));
            return out;
          },
          "Number of rows that each member reached: an array of (members,).")
      .def(
          "__getitem__",
          [](const py::object& self, const std::string& column) {
            const auto& e = self.cast<const EnsembleTrajectory&>();
            const auto at = std::find(e.columns().begin(), e.columns().end(), column);
            if (at == e.columns().end()) {
              throw Error(Error::Kind::input, "there is no column '" + column + "'; see the attribute columns");
            }
            const py::ssize_t number = sizeof(double), row = size(e.columns().size()) * number;
            return view(e.values().data() + (at - e.columns().begin()), {size(e.members()), size(e.times().size())},
                        self, {row * size(e.times().size()), row});
          },
          py::arg("column"), "One output of all members: an array of (members, times).")
      .def("__len__", &EnsembleTrajectory::members)
      .def("__iter__", [](const EnsembleTrajectory& e) { return py::iter(py::cast(e.columns())); })
      .def("__contains__",
           [](const EnsembleTrajectory& e, const std::string& column) {
             return std::find(e.columns().begin(), e.columns().end(), column) != e.columns().end();
           })
      .def("keys", &EnsembleTrajectory::columns, "Names of the outputs.")
      .def(
          "write_csv",
          [](const EnsembleTrajectory& e, const Path& file) {
            write_file(file, [&](std::ostream& out) { write_csv(out, e); });
          },
          py::arg("file"), "Writes a CSV with the columns member (from 1), t (s) and all outputs, SI units.")
      .def(
          "write_npy",
          [](const EnsembleTrajectory& e, const Path& file, std::size_t every, bool single) {
            write_file(file, [&](std::ostream& out) { write_npy(out, e, {every, single}); });
          },
          py::arg("file"), py::arg("every") = 1, py::arg("single") = false,
          "Writes every n-th row for numpy.load(): an array of (members, rows) with the fields t and all outputs. "
          "single: in single precision.")
      .def("__repr__", [](const EnsembleTrajectory& e) {
        return "EnsembleTrajectory(" + plural(e.members(), "member") + ", " + plural(e.times().size(), "time") + ", " +
               plural(e.columns().size(), "column") + ")";
      });

  py::class_<Ensemble::Outcome>(m, "Outcome", R"(The end of one member of an ensemble.)")
      .def_readonly("status", &Ensemble::Outcome::status, "Status: 'ok', or the reason why it stopped.")
      .def_readonly("reached", &Ensemble::Outcome::reached, "Last time with a valid posture, s.")
      .def_readonly("cannot", &Ensemble::Outcome::cannot, "Why the member could not start; '': it started.")
      .def_readonly("alone", &Ensemble::Outcome::alone, "True if it ran apart from the others.")
      .def_readonly("events", &Ensemble::Outcome::events, "Events of this member.")
      .def("__repr__", [](const Ensemble::Outcome& o) {
        return py::str("Outcome({!r}, reached={:g} s)").format(o.status, o.reached).cast<std::string>();
      });

  py::class_<TableEnsemble>(m, "Ensemble",
                            R"(Many variants of one mechanism over the same times, in SIMD lanes. `with` closes it.)")
      .def(py::init([](const Scene& scene, const py::dict& values, const std::string& strategy,
                       std::optional<int> threads, const std::vector<std::string>& without) {
             Table table = table_of(values);
             PrepareOptions options;
             options.strategy = strategy;
             options.budget = threads ? ThreadBudget{*threads} : this_machine().budget();
             options.mode = Mode::throughput;
             options.without = without;
             const py::gil_scoped_release release;
             return TableEnsemble{{std::make_unique<Ensemble>(scene, table.names, std::move(table.values), options),
                                   "ensemble", scene.name()},
                                  table.names};
           }),
           py::arg("scene"), py::arg("values"), py::kw_only(), py::arg("strategy") = "auto",
           py::arg("threads") = py::none(), py::arg("without") = std::vector<std::string>{},
           R"(values: a dict of names and arrays of (members,), or numbers, which all members share.

Names are parameters of the scene, or numbers as written: 'P.x', 'P.y', 'P.z' of a point or joint, 'C' of a constraint.
SI units. No scene is made for a member. Members that cannot be assembled are outcomes.)")
      .def("bind", &TableEnsemble::bind, py::arg("values"),
           "Other values of the same names, SI units: arrays of (members,), or numbers. Takes 0.1 us or so a member "
           "when they run.")
      .def(
          "run",
          [](const TableEnsemble& e, const std::optional<Array>& times, const std::optional<Names>& outputs,
             const py::object& progress) -> py::object {
            bool interrupted = false;
            py::object out =
                py::cast(run_members(e, times, progress, interrupted, [&](Ensemble& ensemble, const auto&... how) {
                  return outputs ? ensemble.run(*outputs, how...) : ensemble.run(how...);
                }));
            if (interrupted) raise_interrupted(out);
            return out;
          },
          py::arg("times") = py::none(), py::kw_only(), py::arg("outputs") = py::none(),
          py::arg("progress") = py::none(),
          R"(Runs all members over the time grid of the scene, or over `times` (s): an array of (times,).

outputs: names of columns to keep; None: all. The others then need no memory, and the numbers are the same bit by bit.
Returns an EnsembleTrajectory, SI units. See Simulator.run() for Ctrl-C and progress.)")
      .def(
          "stream",
          [](const TableEnsemble& e, const py::function& callback, const std::optional<Names>& columns,
             std::size_t every, std::optional<std::size_t> block, const std::optional<Array>& times,
             const py::object& progress) {
            RowSelection selection;
            if (columns) selection.columns = *columns;
            selection.every = every;
            if (block) selection.block = *block;
            bool interrupted = false;
            run_members(e, times, progress, interrupted, [&](Ensemble& ensemble, const auto&... how) {
              ensemble.stream(selection, row_sink(callback, true), how...);
              return true;
            });
            if (interrupted) raise_interrupted(py::none());
          },
          py::arg("callback"), py::kw_only(), py::arg("columns") = py::none(), py::arg("every") = 1,
          py::arg("block") = py::none(), py::arg("times") = py::none(), py::arg("progress") = py::none(),
          R"(Runs all members as run() does, and calls callback(member, t, values) instead of keeping rows.

t: an array of (rows,), s. values: an array of (rows, columns), SI units, of these columns (None: all). every: every
n-th row. block: most rows of one call; None: all rows of a member at once. Members come in any order, the blocks of a
member in theirs. An exception of the callback ends the run. For less work per row, use summarize().)")
      .def(
          "summarize",
          [](const TableEnsemble& e, const Names& columns, const std::optional<Array>& times,
             const py::object& progress) -> py::object {
            bool interrupted = false;
            const EnsembleSummary s = run_members(
                e, times, progress, interrupted,
                [&](Ensemble& ensemble, const auto&... how) { return ensemble.summarize(columns, how...); });
            py::dict out;
            for (std::size_t c = 0; c < columns.size(); ++c) {
              py::dict of;
              const auto add = [&](const char* name, double ColumnSummary::*figure) {
                py::array_t<double> values(size(s.members()));
                for (std::size_t i = 0; i < s.members(); ++i) values.mutable_at(i) = s(i, c).*figure;
                of[name] = values;
              };
              add("minimum", &ColumnSummary::minimum);
              add("maximum", &ColumnSummary::maximum);
              add("minimum_time", &ColumnSummary::minimum_time);
              add("maximum_time", &ColumnSummary::maximum_time);
              add("mean", &ColumnSummary::mean);
              add("last", &ColumnSummary::last);
              out[py::str(columns[c])] = of;
            }
            if (interrupted) raise_interrupted(out);
            return out;
          },
          py::arg("columns"), py::arg("times") = py::none(), py::kw_only(), py::arg("progress") = py::none(),
          "Runs all members and keeps figures of these columns: a dict of columns, each a dict of 'minimum', "
          "'maximum', "
          "'minimum_time', 'maximum_time', 'mean' and 'last', arrays of (members,), SI units. NaN where a member has "
          "no row. times: an array of (times,), s.")
      .def("__len__", [](const TableEnsemble& e) { return e.constant().members(); })
      .def_readonly("names", &TableEnsemble::names, "Names of the values.")
      .def_property_readonly(
          "outcomes", [](const TableEnsemble& e) { return e.use()->outcomes(); },
          "The end of each member in the last run: a list of Outcome.")
      .def_property_readonly(
          "report", [](const TableEnsemble& e) { return e.use()->report(); },
          "Report of the last run: sums and largest errors of all members.")
      .def_property_readonly(
          "prepared",
          [](const TableEnsemble& e) {
            return Ready{e.use()->prepared(), {}};
          },
          "Plan and structure of the first member.")
      .def(
          "close", [](TableEnsemble& e) { e.close(); },
          "Ends threads and returns memory; any later use raises InputError. Results stay valid.")
      .def("__enter__", [](const py::object& self) { return self; })
      .def("__exit__", [](TableEnsemble& e, const py::args&) { e.close(); })
      .def("__repr__", [](const TableEnsemble& e) {
        if (*e.state() != 0) return "Ensemble(" + std::string(e.state()) + ")";
        std::string out = "Ensemble('" + e.name() + "', " + plural(e.constant().members(), "member") + " by";
        for (const std::string& name : e.names) out += " " + name;
        return out + ")";
      });
}

}  // namespace assur::python
