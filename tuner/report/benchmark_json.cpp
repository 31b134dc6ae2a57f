#include "report/benchmark_json.hpp"

#include <unistd.h>

#include <array>
#include <cmath>

#include "db/libraries.hpp"

namespace assur::report {
namespace {

using output::Json;

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

Json context(const Machine& machine, const std::string& date) {
  Json caches = Json::array();
  for (const Cache& cache : machine.caches) {
    caches.push_back({{"type", cache.level == 1 ? "Data" : "Unified"},
                      {"level", cache.level},
                      {"size", cache.bytes},
                      {"num_sharing", cache.cores}});
  }
  return {{"date", date},
          {"host_name", host_name()},
          {"executable", "assur report"},
          {"num_cpus", machine.processors},
          {"caches", caches},
          {"library_version", std::string(db::assur_version())},
          {"library_build_type", db::library_at_hand("assur").build},
          {"machine", to_string(machine)}};
}

// null for what is not finite: JSON has no NaN.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json benchmark(const Measurement& m) {
  const bool is_time = m.unit == "s" && std::isfinite(m.value);
  const std::string run_name = m.section + "/" + m.item + "/" + m.strategy + "/" + m.quantity;
  Json out = {{"name", run_name + "_median"},
              {"run_name", run_name},
              {"run_type", "aggregate"},
              {"repetitions", m.repetitions},
              {"threads", 1},
              {"aggregate_name", "median"},
              {"aggregate_unit", "time"},
              {"iterations", m.repetitions},
              {"real_time", is_time ? 1e9 * m.value : 0.0},
              {"cpu_time", is_time ? 1e9 * m.value : 0.0},
              {"time_unit", "ns"},
              {"label", m.origin}};
  if (!is_time) out[m.quantity] = number(m.value);
  out["relative_spread"] = m.repetitions > 1 ? number(m.spread) : Json(nullptr);
  out["relative_error"] = number(m.error);
  return out;
}

}  // namespace

Json benchmark_json(std::span<const Section> sections, const Machine& machine, const std::string& date) {
  Json benchmarks = Json::array();
  for (const Section& section : sections) {
    for (const Measurement& m : section.measurements) benchmarks.push_back(benchmark(m));
  }
  return {{"context", context(machine, date)}, {"benchmarks", std::move(benchmarks)}};
}

}  // namespace assur::report
