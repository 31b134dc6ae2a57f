#include "report/report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <sstream>

#include "measure/noise.hpp"
#include "measure/step_times.hpp"
#include "output/format.hpp"
#include "output/replace_file.hpp"
#include "report/benchmark_json.hpp"
#include "report/measurement_csv.hpp"

namespace assur::report {
namespace {

namespace fs = std::filesystem;

// ISO 8601 with the offset of the time zone.
std::string now() {
  const std::time_t time = std::time(nullptr);
  std::tm parts{};
  localtime_r(&time, &parts);
  std::array<char, 40> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S%z", &parts);
  return std::string(text.data()).insert(22, ":");
}

class Folder {
 public:
  Folder(fs::path folder, const Knowledge& knowledge, int threads)
      : folder_(std::move(folder)), machine_(knowledge.machine), date_(now()) {
    std::error_code error;
    fs::create_directories(folder_, error);
    if (error) throw Error(Error::Kind::environment, "--out: cannot make " + folder_.string() + ": " + error.message());
    head_ = {facts(knowledge, threads, date_), how_to_tune(knowledge), ""};
  }

  void write(const std::vector<Part>& parts, const std::string& state) {
    head_.state = state;
    std::vector<Section> sections;
    for (const Part& part : parts) sections.insert(sections.end(), part.sections.begin(), part.sections.end());
    std::ostringstream csv;
    write_csv(csv, sections);
    output::replace_file(folder_ / "index.html", page(head_, parts));
    output::replace_file(folder_ / "report.csv", csv.str());
    output::replace_file(folder_ / "report.json", benchmark_json(sections, machine_, date_).dump(1) + "\n");
  }

  [[nodiscard]] std::vector<fs::path> files() const {
    return {folder_ / "index.html", folder_ / "report.csv", folder_ / "report.json"};
  }

 private:
  fs::path folder_;
  const Machine& machine_;
  std::string date_;
  PageHead head_;
};

double shares_from(const std::vector<Planned>& planned, std::size_t first) {
  double sum = 0;
  for (std::size_t i = first; i < planned.size(); ++i) sum += planned[i].share;
  return sum;
}

std::string state_of(bool interrupted, bool done, double seconds) {
  if (interrupted) return "Interrupted after " + output::duration(seconds) + ": not everything is here.";
  if (!done) return "Not finished: it is being made, " + output::duration(seconds) + " so far.";
  return "Made in " + output::duration(seconds) + ".";
}

std::string quiet_text(const measure::NoiseWatch& watch) {
  const measure::Judgement judgement = measure::judge(watch.noise());
  return judgement.quiet == measure::Quiet::yes ? " The machine was quiet."
                                                : " The machine was not quiet: " + judgement.reason + ".";
}

}  // namespace

Outcome make_report(const fs::path& folder, const std::vector<Planned>& planned, const Knowledge& knowledge,
                    const Conditions& whole) {
  const double begin = measure::StepTimes::steady();
  const auto taken = [&] { return measure::StepTimes::steady() - begin; };
  Folder out(folder, knowledge, whole.threads);
  std::vector<Part> parts;
  for (const Planned& p : planned) parts.push_back({p.chapter, p.title, {}, "not made yet"});
  out.write(parts, state_of(false, false, 0));

  Outcome outcome{.files = out.files(), .failures = {}, .parts = {}};
  const measure::NoiseWatch watch(whole.threads);
  for (std::size_t i = 0; i < planned.size() && !outcome.interrupted; ++i) {
    Conditions conditions = whole;
    const double start = taken(), left = std::max(0.0, whole.seconds - start);
    conditions.seconds = left * planned[i].share / shares_from(planned, i);
    whole.progress(start / whole.seconds, planned[i].title);
    try {
      parts[i].sections = planned[i].make(conditions);
      parts[i].missing.clear();
    } catch (const Error& error) {
      parts[i].missing = std::string("could not be made: ") + error.what();
      outcome.failures.push_back(planned[i].title + ": " + error.what());
    }
    outcome.parts.push_back({planned[i].title, taken() - start});
    outcome.interrupted = whole.interrupted();
    if (outcome.interrupted) {
      parts[i].missing = parts[i].sections.empty() ? "interrupted before there was anything to show"
                                                   : "interrupted: what is here is not all of it";
      for (std::size_t k = i + 1; k < parts.size(); ++k) parts[k].missing = "not made, for the report was interrupted";
    }
    out.write(parts, state_of(outcome.interrupted, i + 1 == planned.size(), taken()) + quiet_text(watch));
  }
  return outcome;
}

}  // namespace assur::report
