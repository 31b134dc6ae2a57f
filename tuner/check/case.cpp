#include "check/case.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <set>

#include "check/case_files.hpp"
#include "output/format.hpp"

namespace assur::check {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array kVerdicts = {"pass",           "refused",      "singular", "not_finite",   "not_converged",
                                  "inaccurate",     "inconsistent", "fold",     "out_of_range", "change_point_passed",
                                  "branch_unknown", "actuator_zero"};

// Reads one case; every key must be known and of the right type.
class Reader {
 public:
  // scenes: scenes of the file that several cases share, by name.
  Reader(const Json& json, const Json& scenes, std::string where)
      : json_(json), scenes_(scenes), where_(std::move(where)) {}

  std::vector<Case> cases(const std::string& family) {
    Case c;
    c.family = family;
    c.name = need<std::string>("name");
    where_ += ": " + c.name;
    c.about = need<std::string>("about");
    take("sample", c.text);
    if (json_.contains("scene")) c.scene = scene();
    take("maker", c.maker);
    take("matrix", c.matrix);
    const int sources = !c.text.empty() + !c.scene.empty() + !c.maker.empty() + !c.matrix.empty();
    if (sources != 1) refuse("needs exactly one of \"sample\", \"scene\", \"maker\" and \"matrix\"");
    c.set = parameters("set");
    c.twin = parameters("twin");
    if (json_.contains("time")) {
      const auto time = need<std::array<double, 3>>("time");
      c.time = TimeGrid{time[0], time[1], time[2]};
    }
    take("outputs", c.outputs);
    take("accuracy", c.accuracy);
    take("iterations", c.iterations);
    take("strategies", c.strategies);
    for (const std::string& name : value<std::vector<std::string>>("formulations")) {
      c.formulations.push_back(parse_strategy(name + "/eigen").run.formulation);
    }
    take("closed_form", c.closed_form);
    take("plain", c.plain);
    take("singularity", c.singularity);
    take("because", c.because);
    take("quick", c.quick);
    std::vector<Case> all = swept(std::move(c));
    for (const auto& [key, unused] : json_.items()) {
      if (!known_.contains(key)) refuse("cannot have the key \"" + key + "\"");
    }
    return all;
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const {
    throw Error(Error::Kind::input, where_ + ": a case " + what);
  }

  template <class T>
  T need(const char* key) {
    if (!json_.contains(key)) refuse("needs the key \"" + std::string(key) + "\"");
    return value<T>(key);
  }
  template <class T>
  T value(const char* key) {
    known_.insert(key);
    if (!json_.contains(key)) return {};
    try {
      return json_.at(key).get<T>();
    } catch (const Json::exception&) {
      refuse("has a value of the wrong type for \"" + std::string(key) + "\"");
    }
  }
  template <class T>
  void take(const char* key, T& into) {
    known_.insert(key);
    if (json_.contains(key)) into = value<T>(key);
  }
  std::string scene() {
    const Json scene = need<Json>("scene");
    if (!scene.is_string()) return scene.dump();
    const auto shared = scenes_.find(scene.get<std::string>());
    if (shared == scenes_.end()) refuse("names a \"scene\" that the file does not have: " + scene.dump());
    return shared->dump();
  }

  Parameters parameters(const char* key) {
    const auto numbers = value<std::map<std::string, double>>(key);
    return {numbers.begin(), numbers.end()};
  }

  // The case, or one case for each value of its sweep.
  std::vector<Case> swept(Case c) {
    known_.insert({"sweep", "expected", "expected_each"});
    if (!json_.contains("sweep")) {
      c.expected = expectation(need<Json>("expected"), c);
      return {c};
    }
    const Json sweep = need<Json>("sweep");
    if (!sweep.is_object() || sweep.size() != 1) refuse("can sweep one parameter only: {\"gap\": [0.1, 0.01]}");
    const std::string parameter = sweep.begin().key();
    const auto values = sweep.begin().value().get<std::vector<double>>();
    const Json each = value<Json>("expected_each");
    if (json_.contains("expected") != each.is_null()) refuse("needs either \"expected\" or \"expected_each\"");
    if (!each.is_null() && each.size() != values.size())
      refuse("needs one entry of \"expected_each\" for each value of its sweep");
    std::vector<Case> all;
    for (std::size_t i = 0; i < values.size(); ++i) {
      Case one = c;
      one.name += " " + parameter + "=" + output::number(values[i]);
      one.set[parameter] = values[i];
      one.expected = expectation(each.is_null() ? need<Json>("expected") : each[i], c);
      all.push_back(std::move(one));
    }
    return all;
  }

  // "pass", ["inaccurate", "fold"], or {"refused": "part of the message"}
  Expected expectation(const Json& json, const Case& c) const {
    Expected out;
    if (json.is_object() && json.size() == 1 && json.contains("refused")) {
      out.verdicts = {"refused"};
      out.message = json["refused"].get<std::string>();
    } else if (json.is_array()) {
      for (const Json& item : json) {
        const Expected one = expectation(item, c);
        out.verdicts.push_back(one.verdicts.front());
        if (!one.message.empty()) out.message = one.message;
      }
    } else if (json.is_string()) {
      out.verdicts = {json.get<std::string>()};
    }
    if (out.verdicts.empty()) refuse("can expect \"pass\", a code, {\"refused\": text} or a list of these");
    for (const Verdict& v : out.verdicts) {
      if (std::find(kVerdicts.begin(), kVerdicts.end(), v) == kVerdicts.end()) refuse("cannot expect \"" + v + "\"");
    }
    if (out.verdicts.size() > 1 && c.because.empty())
      refuse("with several expected verdicts needs a reason: \"because\"");
    return out;
  }

  const Json& json_;
  const Json& scenes_;
  std::string where_;
  std::set<std::string> known_;
};

}  // namespace

std::string to_string(const Expected& expected) {
  std::string text;
  for (const Verdict& v : expected.verdicts) text += (text.empty() ? "" : " or ") + v;
  return text.empty() ? "same verdict of all" : text;
}

std::vector<Case> parse_cases(std::string_view text, const std::string& file) {
  Json json;
  try {
    json = Json::parse(text, nullptr, true, true);
  } catch (const Json::parse_error& error) {
    throw Error(Error::Kind::input, file + ": " + error.what());
  }
  if (!json.is_object() || !json.contains("family") || !json.contains("cases")) {
    throw Error(Error::Kind::input, file + ": must be {\"family\": name, \"scenes\": {...}, \"cases\": [...]}");
  }
  std::vector<Case> all;
  std::set<std::string> names;
  const Json scenes = json.value("scenes", Json::object());
  for (const Json& item : json["cases"]) {
    for (Case& c : Reader(item, scenes, file).cases(json["family"].get<std::string>())) {
      if (!names.insert(c.name).second) throw Error(Error::Kind::input, file + ": two cases have the name " + c.name);
      all.push_back(std::move(c));
    }
  }
  return all;
}

std::vector<Case> all_cases() {
  std::vector<Case> all;
  for (const CaseFile& file : case_files()) {
    for (Case& c : parse_cases(file.text, std::string(file.name))) all.push_back(std::move(c));
  }
  return all;
}

}  // namespace assur::check
