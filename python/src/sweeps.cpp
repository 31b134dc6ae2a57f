// Sweeps: figures of many designs.
#include "sweep/sweep.hpp"

#include <algorithm>
#include <atomic>
#include <thread>

#include "module.hpp"

namespace assur::python {
namespace {

using Names = std::vector<std::string>;

sweep::Sampler sampler_of(const std::string& name) {
  if (name == "grid") return sweep::Sampler::grid;
  if (name == "random") return sweep::Sampler::random;
  if (name == "sobol") return sweep::Sampler::sobol;
  throw Error(Error::Kind::input, "sampler is 'grid', 'random' or 'sobol', not '" + name + "'");
}

void check_name(const char* what, const std::string& name, const Names& known) {
  if (std::find(known.begin(), known.end(), name) != known.end()) return;
  std::string all;
  for (const std::string& k : known) all += (all.empty() ? "'" : ", '") + k + "'";
  throw Error(Error::Kind::input, std::string(what) + " knows " + all + ", but not '" + name + "'");
}

std::optional<sweep::Trace> trace_of(const Scene& scene, const Names& columns, const std::string& point,
                                     const std::optional<Array>& target, const std::string& distance) {
  if (point.empty() != !target) {
    throw Error(Error::Kind::input, "a path is compared with a curve: give both `trace` and `target`");
  }
  if (!target) return std::nullopt;
  check_name("compare", distance, sweep::distance_names());
  sweep::check_point(point, scene, columns);
  sweep::Trace trace{point, curve_of(*target), distance};
  sweep::check_target(trace, scene);
  return trace;
}

// All samples have the same times.
void check_grid(const Scene& scene, const sweep::DesignSpace& space, std::int64_t first) {
  Parameters values;
  const std::vector<double> point = space.point(first);
  for (std::size_t i = 0; i < point.size(); ++i) values[space.ranges()[i].name] = point[i];
  std::optional<Scene> other;
  try {
    other = scene.with_values(values);
  } catch (const Error&) {
    return;  // a sample of which there is no scene
  }
  sweep::check_same_times(scene, *other);
}

// The columns of the file that `assur sweep` writes.
struct Table {
  const sweep::DesignSpace& space;
  Names figures;
  std::vector<std::int64_t> samples;
  std::vector<double> reached;
  Names status;
  std::vector<std::vector<double>> parameters, values;

  void take(const sweep::DesignSample& row) {
    samples.push_back(row.sample);
    status.push_back(row.status);
    reached.push_back(row.reached);
    for (std::size_t i = 0; i < parameters.size(); ++i) parameters[i].push_back(row.parameters[i]);
    for (std::size_t i = 0; i < values.size(); ++i) values[i].push_back(row.figures[i]);
  }
  [[nodiscard]] py::dict columns() const {
    const auto array = [](const auto& of) {
      using Number = std::decay_t<decltype(of[0])>;
      return py::array_t<Number>(static_cast<py::ssize_t>(of.size()), of.data());
    };
    py::dict out;
    out["sample"] = array(samples);
    for (std::size_t i = 0; i < parameters.size(); ++i) out[py::str(space.ranges()[i].name)] = array(parameters[i]);
    out["status"] = py::module_::import("numpy").attr("array")(status, py::arg("dtype") = "U");
    out["reached"] = array(reached);
    for (std::size_t i = 0; i < values.size(); ++i) out[py::str(figures[i])] = array(values[i]);
    return out;
  }
};

// Findings about options of the command as findings about arguments.
[[noreturn]] void rethrow_about_arguments(const Error& e) {
  std::vector<Diagnostic> all = e.diagnostics();
  for (Diagnostic& d : all) {
    if (d.where.starts_with("--")) d.where.erase(0, 2);
  }
  throw Error(e.kind(), std::move(all));
}

py::object run(const Scene& scene, const py::dict& vary, std::int64_t samples, const std::string& sampler,
               std::uint64_t seed, std::optional<std::pair<std::int64_t, std::int64_t>> range, const Names& reduce,
               const std::string& trace, const std::optional<Array>& target, const std::string& compare,
               const std::string& strategy, std::optional<int> threads, const py::object& progress) {
  std::vector<sweep::Range> ranges;
  Parameters middle;
  for (const auto& [name, ends] : vary) {
    const auto [low, high] = ends.cast<std::pair<double, double>>();
    ranges.push_back({name.cast<std::string>(), low, high});
    middle[ranges.back().name] = low + (high - low) / 2;
  }
  const sweep::DesignSpace space(ranges, sampler_of(sampler), samples, seed);
  const auto [first, last] = range.value_or(std::pair<std::int64_t, std::int64_t>{0, samples});
  if (first < 0 || last <= first || last > samples) {
    throw Error(Error::Kind::input, "range: (first, last) from 0 to " + std::to_string(samples));
  }
  for (const std::string& figure : reduce) check_name("reduce", figure, sweep::figure_names());
  const Scene at_middle = scene.with_values(middle);
  const Names columns = sweep::columns_of(at_middle);
  if (columns.empty()) throw Error(Error::Kind::input, "the scene has no outputs, so that there is nothing to keep");
  check_grid(at_middle, space, first);
  PrepareOptions how;
  how.strategy = strategy;
  how.mode = Mode::throughput;
  how.budget = threads ? ThreadBudget{*threads} : this_machine().budget();

  const std::int64_t of = last - first;
  bool interrupted = false;
  std::optional<Table> table;
  run_watched(progress, interrupted, [&](const Observer& observer) {
    // Threads of the plan ask whether to stop; only this one may look for Ctrl-C.
    std::atomic<bool> stopped = false;
    const std::thread::id own = std::this_thread::get_id();
    StepSettings settings;
    settings.stop = [&] {
      if (std::this_thread::get_id() == own && !stopped) {
        stopped = observer(table ? static_cast<std::int64_t>(table->samples.size()) : 0, of);
      }
      return stopped.load();
    };
    sweep::Sweep sweep(space, at_middle, how, columns, reduce, trace_of(at_middle, columns, trace, target, compare),
                       settings);
    const Names figures = sweep.figures();
    table.emplace(Table{space, figures, {}, {}, {}, {}, {}});
    table->parameters.resize(ranges.size());
    table->values.resize(figures.size());
    for (std::int64_t b = first / sweep::Sweep::kBlock; !stopped && b * sweep::Sweep::kBlock < last; ++b) {
      for (const sweep::DesignSample& row : sweep.block(b)) {
        if (row.sample >= first && row.sample < last) table->take(row);
      }
    }
    observer(static_cast<std::int64_t>(table->samples.size()), of);
    return true;
  });
  py::object out = table->columns();
  if (interrupted) raise_interrupted(out);
  return out;
}

}  // namespace

void add_sweeps(py::module_& m) {
  m.def(
      "sweep",
      [](const Scene& scene, const py::dict& vary, std::int64_t samples, const std::string& sampler, std::uint64_t seed,
         std::optional<std::pair<std::int64_t, std::int64_t>> range, const Names& reduce, const std::string& trace,
         const std::optional<Array>& target, const std::string& compare, const std::string& strategy,
         std::optional<int> threads, const py::object& progress) {
        try {
          return run(scene, vary, samples, sampler, seed, range, reduce, trace, target, compare, strategy, threads,
                     progress);
        } catch (const Error& e) {
          rethrow_about_arguments(e);
        }
      },
      py::arg("scene"), py::arg("vary"), py::arg("samples"), py::kw_only(), py::arg("sampler") = "random",
      py::arg("seed") = 0, py::arg("range") = py::none(), py::arg("reduce") = Names{"min", "max"},
      py::arg("trace") = "", py::arg("target") = py::none(), py::arg("compare") = "nearest",
      py::arg("strategy") = "auto", py::arg("threads") = py::none(), py::arg("progress") = py::none(),
      R"(Figures of many designs, as `assur sweep`: the same numbers, bit by bit.

vary: a dict of parameters (names as in Ensemble) and their ranges (low, high), SI units. samples: of the whole space.
sampler: 'random', 'sobol' (fills the space evenly) or 'grid'. range: (first, last) computes only these samples, which
do not depend on the others. reduce: figures of each output: 'min', 'max', 'min_time', 'max_time', 'mean', 'last',
'range'. trace, target, compare: a point whose path is compared with a curve, an array of (points, 2), m, by 'nearest',
'timed', 'fitted' or 'shape' distance.
Returns a dict of arrays of (samples,): 'sample', the parameters, 'status' ('ok', ..., 'not_assembled'), 'reached' (s),
and figures: 'C.distance', 'limits' (how often one was exceeded), 'C.x.min', ... in SI units; NaN if not assembled.)");
}

}  // namespace assur::python
