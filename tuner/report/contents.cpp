#include "report/contents.hpp"

#include <sstream>

#include "report/paper/tables.hpp"
#include "report/peers.hpp"
#include "report/sections.hpp"
#include "scene/input_file.hpp"

namespace assur::report {
namespace {

std::vector<Section> paper(const Knowledge& knowledge, double watts, const Conditions& conditions) {
  PaperOptions options;
  options.seconds = conditions.seconds;
  options.quick = conditions.quick;
  options.threads = conditions.threads;
  options.interrupted = conditions.interrupted;
  options.progress = conditions.progress;
  options.model = knowledge.known.model;
  options.watts = watts;
  return reproduce_paper(options);
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
      {kHere, "Which strategy wins", 0.01, one(winners)},
      {kHere, "What auto loses", 0.35, one(regret)},
      {kHere, "Error against run time", 0.25, one(work_precision)},
      {kHere, "How it scales: threads, lanes, variants", 0.25, one(scaling)},
      {kHere, "How long single steps take", 0.06, one(step_histogram)},
      {kHere, "What tuning costs, and what it saves", 0.04, one(tuning_cost)},
      {kHere, "How well times are predicted", 0.04, one(model_fit)},
      {"The paper again", "The paper's tables, figures and conclusions", 1,
       [&knowledge, watts = wishes.watts](const Conditions& conditions) {
         return paper(knowledge, watts, conditions);
       }},
  };
  if (!wishes.peers.empty()) {
    all.push_back({"Beside others", "Other libraries on the same mechanisms", 0.01,
                   [peers = peers_of(wishes.peers)](const Conditions&) { return std::vector{peers}; }});
  }
  return all;
}

}  // namespace assur::report
