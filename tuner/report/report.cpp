#include "report/report.hpp"

#include <algorithm>
#include <array>
#include <ctime>
#include <sstream>

#include "files/input_file.hpp"
#include "measure/noise.hpp"
#include "measure/step_times.hpp"
#include "output/format.hpp"
#include "output/replace_file.hpp"
#include "report/page.hpp"
#include "report/paper/tables.hpp"

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
  Folder(const fs::path& folder, const Knowledge& knowledge, int threads)
      : files{folder / "index.html", folder / "report.csv", folder / "report.json"},
        machine_(knowledge.machine),
        date_(now()),
        head_{facts(knowledge, threads, date_), how_to_tune(knowledge), ""} {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) throw Error(Error::Kind::environment, "--out: cannot make " + folder.string() + ": " + error.message());
  }

  void write(const std::vector<Part>& parts, const std::string& state) {
    head_.state = state;
    std::vector<Section> sections;
    for (const Part& part : parts) sections.insert(sections.end(), part.sections.begin(), part.sections.end());
    output::replace_file(files[0], page(head_, parts));
    output::replace_file(files[1], csv_of(sections));
    output::replace_file(files[2], benchmark_json(sections, machine_, date_).dump(1) + "\n");
  }

  const std::vector<fs::path> files;

 private:
  const Machine& machine_;
  std::string date_;
  PageHead head_;
};

std::string state_of(bool interrupted, bool done, double seconds) {
  if (interrupted) return "Interrupted after " + output::duration(seconds) + ": the report is incomplete.";
  if (!done) return "Not finished: in progress for " + output::duration(seconds) + ".";
  return "Made in " + output::duration(seconds) + ".";
}

std::string quiet_text(const measure::NoiseWatch& watch) {
  const measure::NoiseAssessment noise = measure::assess(watch.noise());
  return noise.quiet == measure::Quiet::yes ? " The machine was quiet."
                                            : " The machine was not quiet: " + noise.reason + ".";
}

Section peers_of(const std::string& file) {
  const InputFile found = read_input(file, kLargestTable);
  if (!found.why_not.empty()) {
    throw Error(Error::Kind::input, {{"--peers", "cannot read " + file + ": " + found.why_not}});
  }
  std::istringstream in(found.text);
  return peers_section(in, file);
}

}  // namespace

std::vector<Planned> contents(const Knowledge& knowledge, const Wishes& wishes) {
  const auto one = [&knowledge](Section (*make)(const Knowledge&, const Conditions&)) {
    return [&knowledge, make](const Conditions& conditions) { return std::vector{make(knowledge, conditions)}; };
  };
  constexpr const char* kHere = "This machine";
  std::vector<Planned> all = {
      {kHere, "Fastest strategies", 0.01, one(winners)},
      {kHere, "Regret of auto", 0.35, one(regret)},
      {kHere, "Error against run time", 0.25, one(work_precision)},
      {kHere, "Scaling: threads, lanes, variants", 0.25, one(scaling)},
      {kHere, "Times of single steps", 0.06, one(step_histogram)},
      {kHere, "Cost and benefit of tuning", 0.04, one(tuning_cost)},
      {kHere, "Accuracy of predicted times", 0.04, one(model_fit)},
      {"Repetition of the paper", "The paper's tables, figures and conclusions", 1,
       [&knowledge, watts = wishes.watts](const Conditions& conditions) {
         return reproduce_paper({conditions, knowledge.known.model, watts});
       }},
  };
  if (!wishes.peers.empty()) {
    all.push_back({"Comparison with other libraries", "Other libraries on the same mechanisms", 0.01,
                   [peers = peers_of(wishes.peers)](const Conditions&) { return std::vector{peers}; }});
  }
  return all;
}

Outcome make_report(const fs::path& folder, const std::vector<Planned>& planned, const Knowledge& knowledge,
                    const Conditions& whole) {
  const double begin = measure::StepTimes::steady();
  const auto taken = [&] { return measure::StepTimes::steady() - begin; };
  Folder out(folder, knowledge, whole.threads);
  std::vector<Part> parts;
  for (const Planned& p : planned) parts.push_back({p.chapter, p.title, {}, "not made yet"});
  out.write(parts, state_of(false, false, 0));

  Outcome outcome{.files = out.files, .failures = {}, .parts = {}};
  const measure::NoiseWatch watch(whole.threads);
  for (std::size_t i = 0; i < planned.size() && !outcome.interrupted; ++i) {
    Conditions conditions = whole;
    const double start = taken(), left = std::max(0.0, whole.seconds - start);
    double shares = 0;
    for (std::size_t k = i; k < planned.size(); ++k) shares += planned[k].share;
    conditions.seconds = left * planned[i].share / shares;
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
      parts[i].missing = parts[i].sections.empty() ? "interrupted before the first result" : "interrupted: incomplete";
      for (std::size_t k = i + 1; k < parts.size(); ++k)
        parts[k].missing = "not made, because the report was interrupted";
    }
    out.write(parts, state_of(outcome.interrupted, i + 1 == planned.size(), taken()) + quiet_text(watch));
  }
  return outcome;
}

}  // namespace assur::report
