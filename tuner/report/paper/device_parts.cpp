#include "report/paper/device_parts.hpp"

#include <array>
#include <cmath>
#include <utility>

#include "assur/strategy.hpp"
#include "backends/backends.hpp"
#include "measure/linear.hpp"
#include "measure/step_times.hpp"
#include "median.hpp"
#include "output/format.hpp"
#include "report/paper/paper.hpp"

namespace assur::report {
namespace {

constexpr int kEntriesInARow = 6;  // as in mechanisms
constexpr int kCalls = 9;          // a median and a spread
constexpr double kSeconds = 0.5;   // for the calls of the processor; at least three

using enum HtmlTable::Column;
using Column = pictures::ColumnOf<DeviceParts>;
using Call = cusolver::CallTimes;

struct CallPart {
  const char* name;
  double (*seconds)(const Call&);
};
constexpr std::array kParts = {
    CallPart{"whole", [](const Call& t) { return t.whole; }},
    CallPart{"upload", [](const Call& t) { return t.upload; }},
    CallPart{"computation", [](const Call& t) { return t.compute; }},
    CallPart{"download", [](const Call& t) { return t.download; }},
    CallPart{"launches and rest", [](const Call& t) { return t.whole - t.upload - t.compute - t.download; }}};

struct NamedCall {
  const char* name;
  Call cusolver::Breakdown::*times;
};
constexpr std::array kBoth = {NamedCall{"LU", &cusolver::Breakdown::factorize},
                              NamedCall{"solution", &cusolver::Breakdown::solve}};

// Of at least three calls; NaN if one fails.
double median_of_calls(measure::Workload& work) {
  std::vector<double> seconds;
  const double begin = measure::StepTimes::steady();
  for (double start = begin; seconds.size() < 3 || (seconds.size() < kCalls && start - begin < kSeconds);) {
    if (!work.run(1)) return kNan;
    const double end = measure::StepTimes::steady();
    seconds.push_back(end - start);
    start = end;
  }
  return median(std::move(seconds));
}

std::string ms(double seconds) { return std::isnan(seconds) ? "-" : ratio_text(1e3 * seconds); }

std::string item(const DeviceParts& p) { return "random matrix, n = " + std::to_string(p.n); }

}  // namespace

std::string cpu_beside_device(const std::string& dense, int threads) {
  return "global/" + dense + (threads > 1 && properties_of(dense).threads ? " 1x2" : "");
}

std::vector<DeviceParts> measure_device_parts(const std::string& on_cpu, const std::function<bool()>& interrupted) {
  const Strategy strategy = parse_strategy(on_cpu);
  const Backend& backend = find_backend(backends(), strategy.solver.backend);
  std::vector<DeviceParts> all;
  for (const PaperCell& cell : cells_of_table(5)) {
    if (interrupted()) break;
    const measure::Matrices m = measure::random_matrices(cell.n, kEntriesInARow, 1);
    DeviceParts& parts = all.emplace_back();
    parts.n = cell.n;
    parts.calls = kCalls;
    try {
      parts.times = cusolver::break_down(m.pattern, m.values[0], kCalls);
    } catch (const Error& error) {
      parts.why_not = error.what();
      break;
    }
    measure::Linear linear(m, strategy, backend);
    if (!linear.refused().empty()) continue;
    parts.cpu_lu = median_of_calls(linear.factor());
    parts.cpu_solution = median_of_calls(linear.solve());
  }
  return all;
}

void add_device_parts(Section& section, const std::vector<DeviceParts>& parts, const std::string& on_cpu) {
  if (parts.empty()) return;
  std::vector<Column> columns = {{"n", number, [](const DeviceParts& p) { return std::to_string(p.n); }}};
  for (const NamedCall& call : kBoth) {
    for (const CallPart& part : kParts) {
      columns.push_back({std::string(call.name) + ": " + part.name + ", ms", number, [&](const DeviceParts& p) {
                           return p.why_not.empty() ? ms(part.seconds(p.times.*call.times)) : "-";
                         }});
      for (const DeviceParts& p : parts) {
        if (!p.why_not.empty()) continue;
        section.measurements.push_back({item(p), "cusolver", std::string(call.name) + ", " + part.name, "s",
                                        part.seconds(p.times.*call.times), "measured", p.calls, 0,
                                        p.times.backward_error});
      }
    }
  }
  const auto cpu = on_cpu.substr(on_cpu.find('/') + 1);
  columns.push_back({"LU by " + cpu + ", ms", number, [](const DeviceParts& p) { return ms(p.cpu_lu); }});
  columns.push_back({"CPU/GPU, LU and solution", number, [](const DeviceParts& p) {
                       const double gpu = p.times.factorize.whole + p.times.solve.whole;
                       return std::isnan(p.cpu_lu) ? "-" : ratio_text((p.cpu_lu + p.cpu_solution) / gpu);
                     }});
  columns.push_back({"backward error on the GPU", number, [](const DeviceParts& p) {
                       return p.why_not.empty() ? output::error_figure(p.times.backward_error) : "-";
                     }});
  if (!parts.back().why_not.empty()) columns.push_back({"", words, [](const DeviceParts& p) { return p.why_not; }});
  for (const DeviceParts& p : parts) {
    if (std::isnan(p.cpu_lu)) continue;
    section.measurements.push_back({item(p), cpu, "LU, whole", "s", p.cpu_lu, "measured", 3});
    section.measurements.push_back({item(p), cpu, "solution, whole", "s", p.cpu_solution, "measured", 3});
  }
  section.body +=
      paragraph(
          "One LU and one solution of a single system by cusolver, medians. Copies and computation are by the clock of "
          "the GPU. The rest: launches, waiting, and the work of the processor, which writes the nonzeros into the "
          "dense matrix. Beside it the processor in the same minute: " +
          cpu + ".") +
      html(pictures::table_of(parts, columns), "small tall");
}

}  // namespace assur::report
