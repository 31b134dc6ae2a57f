#include "report/section.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <locale>
#include <sstream>

#include "db/libraries.hpp"
#include "decimal.hpp"
#include "output/csv_text.hpp"
#include "output/format.hpp"

namespace assur::report {
namespace {

using output::Json;

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

// null for infinite numbers and NaN, which JSON lacks.
Json or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json benchmark(const std::string& section, const Measurement& m) {
  const bool is_time = m.unit == "s" && std::isfinite(m.value);
  const std::string run_name = section + "/" + m.item + "/" + m.strategy + "/" + m.quantity;
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
  if (!is_time) out[m.quantity] = or_null(m.value);
  out["relative_spread"] = m.repetitions > 1 ? or_null(m.spread) : Json(nullptr);
  out["relative_error"] = or_null(m.error);
  return out;
}

}  // namespace

Measurement derived(Measurement of, const std::string& quantity, double ratio, const std::string& origin) {
  of.quantity = quantity;
  of.unit = "1";
  of.value = ratio;
  of.origin = origin;
  return of;
}

std::string value_text(const Measurement& m) {
  if (!std::isfinite(m.value)) return "-";
  if (m.unit == "s") return output::duration(m.value);
  return general(m.value, 3) + (m.unit == "1" || m.unit.empty() ? "" : " " + m.unit);
}

std::string percent(double share) { return fixed(100 * share, std::abs(share) < 0.0995 ? 1 : 0) + " %"; }

std::string about(const Measurement& m) {
  std::string text = m.strategy.empty() ? m.item : m.strategy;
  text += ": " + value_text(m) + "; ";
  if (m.repetitions > 0) {
    text += output::counted(m.repetitions, "repetition") + ", ";
    if (m.repetitions > 1) text += "spread " + percent(m.spread) + ", ";
  }
  if (!std::isnan(m.error)) text += "error " + output::error_figure(m.error) + ", ";
  return text + m.origin;
}

HtmlTable table_of(std::span<const Measurement> measurements, std::size_t most) {
  using enum HtmlTable::Column;
  using M = Measurement;
  const std::vector<M> shown(measurements.begin(), measurements.begin() + std::min(most, measurements.size()));
  return pictures::table_of<M>(
      shown,
      {{"what", text, [](const M& m) { return m.item; }},
       {"strategy", text, [](const M& m) { return m.strategy; }},
       {"quantity", text, [](const M& m) { return m.quantity; }},
       {"value", number, value_text},
       {"repetitions", number, [](const M& m) { return m.repetitions > 0 ? std::to_string(m.repetitions) : ""; }},
       {"spread", number, [](const M& m) { return m.repetitions > 1 ? percent(m.spread) : ""; }},
       {"error", number, [](const M& m) { return std::isnan(m.error) ? "" : output::error_figure(m.error); }},
       {"origin", words, [](const M& m) { return m.origin; }}});
}

std::string csv_of(std::span<const Section> sections) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out.precision(17);
  out << "section,item,strategy,quantity,unit,value,repetitions,spread,error,origin\n";
  for (const Section& section : sections) {
    for (const Measurement& m : section.measurements) {
      for (const std::string& text : {section.id, m.item, m.strategy, m.quantity, m.unit})
        out << output::csv_text(text) << ',';
      if (!std::isnan(m.value)) out << m.value;
      out << ',' << m.repetitions << ',';
      if (m.repetitions > 1) out << m.spread;
      out << ',';
      if (!std::isnan(m.error)) out << m.error;
      out << ',' << output::csv_text(m.origin) << '\n';
    }
  }
  return out.str();
}

Json benchmark_json(std::span<const Section> sections, const Machine& machine, const std::string& date) {
  Json caches = Json::array(), benchmarks = Json::array();
  for (const Cache& cache : machine.caches) {
    caches.push_back({{"type", cache.level == 1 ? "Data" : "Unified"},
                      {"level", cache.level},
                      {"size", cache.bytes},
                      {"num_sharing", cache.cores}});
  }
  for (const Section& section : sections) {
    for (const Measurement& m : section.measurements) benchmarks.push_back(benchmark(section.id, m));
  }
  return {{"context",
           {{"date", date},
            {"host_name", host_name()},
            {"executable", "assur report"},
            {"num_cpus", machine.processors},
            {"caches", std::move(caches)},
            {"library_version", std::string(db::assur_version())},
            {"library_build_type", db::library_at_hand("assur").build},
            {"machine", to_string(machine)}}},
          {"benchmarks", std::move(benchmarks)}};
}

}  // namespace assur::report
