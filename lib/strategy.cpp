#include "assur/strategy.hpp"

#include <array>
#include <charconv>
#include <limits>
#include <optional>
#include <utility>

#include "assur/backend.hpp"
#include "assur/status.hpp"

namespace assur {
namespace {

constexpr std::string_view kGrammar =
    "global|groups|irreducible/BACKEND[:1|2|4|8|16][+float][+refine][+reuse=step|run][+once|+separate]"
    "[+together][+predict=taylor:0..2|hermite:5|past:0..5][+chunks=C] [PxQ]";

constexpr std::array kFormulations = {Formulation::global, Formulation::groups, Formulation::irreducible};

struct PredictorForm {
  std::string_view name;
  Predictor::Kind kind;
  int lowest, highest;  // order
};
constexpr std::array kPredictors = {PredictorForm{"taylor", Predictor::Kind::taylor, 0, 2},
                                    PredictorForm{"hermite", Predictor::Kind::hermite, 5, 5},
                                    PredictorForm{"past", Predictor::Kind::past, 0, 5}};

constexpr std::array<std::string_view, 8> kKeys = {"float",    "refine",   "reuse",   "once",
                                                   "separate", "together", "predict", "chunks"};

std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

// Decimal digits only: no sign, no leading zero, no overflow.
std::optional<std::int32_t> number(std::string_view text) {
  std::int32_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool plain = !text.empty() && text[0] != '-' && (text[0] != '0' || text.size() == 1);
  if (error != std::errc() || end != text.data() + text.size() || !plain) return std::nullopt;
  return value;
}

std::optional<std::int32_t> positive(std::string_view text) {
  const auto value = number(text);
  return value && *value > 0 ? value : std::nullopt;
}

bool is_id(std::string_view text) {
  if (text.empty() || text[0] < 'a' || text[0] > 'z') return false;
  return text.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == text.npos;
}

// Reads a strategy from left to right; throws at the first invalid part.
class Reader {
 public:
  explicit Reader(std::string_view text) : text_(text) {}

  Strategy read() {
    const auto [word, split, has_split] = cut(text_, ' ');
    const auto [head, options, has_options] = cut(word, '+');
    read_head(head);
    if (has_options) read_options(options);
    if (has_split) read_split(split);
    return strategy_;
  }

 private:
  struct Cut {
    std::string_view before, after;
    bool found;
  };
  static Cut cut(std::string_view text, char separator) {
    const auto at = text.find(separator);
    if (at == text.npos) return {text, {}, false};
    return {text.substr(0, at), text.substr(at + 1), true};
  }

  [[noreturn]] void refuse(const std::string& what) const {
    throw Error(Error::Kind::input,
                "strategy " + quoted(text_) + ": " + what + "; the form is " + std::string(kGrammar));
  }

  void read_head(std::string_view head) {
    const auto [formulation, solver, has_solver] = cut(head, '/');
    bool known = false;
    for (Formulation f : kFormulations) {
      if (name(f) != formulation) continue;
      strategy_.run.formulation = f;
      known = true;
    }
    if (!known) refuse(quoted(formulation) + " is not a formulation: use global, groups or irreducible");
    if (!has_solver) refuse("\"/BACKEND\" is missing after " + quoted(formulation));

    const auto [backend, lanes, has_lanes] = cut(solver, ':');
    if (!is_id(backend)) refuse(quoted(backend) + " is not the name of a backend");
    strategy_.solver.backend = backend;
    if (has_lanes) read_lanes(lanes);
  }

  void read_lanes(std::string_view text) {
    const auto lanes = positive(text);
    if (!lanes || *lanes > kMostLanes || (*lanes & (*lanes - 1)) != 0) {
      refuse(quoted(text) + " is not a number of lanes: use 1, 2, 4, 8 or 16");
    }
    strategy_.solver.lanes = *lanes;
  }

  void read_options(std::string_view options) {
    std::array<bool, kKeys.size()> seen{};
    for (bool more = true; more;) {
      const Cut next = cut(options, '+');
      read_option(next.before, seen);
      options = next.after;
      more = next.found;
    }
    if (strategy_.solver.once && strategy_.solver.separate) {
      refuse("options \"once\" and \"separate\" contradict each other: one factorisation for a step, or one more");
    }
  }

  void read_option(std::string_view option, std::array<bool, kKeys.size()>& seen) {
    const auto [key, value, has_value] = cut(option, '=');
    std::size_t index = 0;
    while (index < kKeys.size() && kKeys[index] != key) ++index;
    if (index == kKeys.size())
      refuse(quoted(option) +
             " is not an option: use float, refine, reuse, once, separate, together, predict or chunks");
    if (std::exchange(seen[index], true)) refuse("option " + quoted(key) + " is given twice");

    const bool wants_value = key == "reuse" || key == "predict" || key == "chunks";
    if (wants_value && !has_value) refuse("option " + quoted(key) + " needs a value");
    if (!wants_value && has_value) refuse("option " + quoted(key) + " takes no value");

    if (key == "float") strategy_.solver.single = true;
    if (key == "refine") strategy_.solver.refine = true;
    if (key == "once") strategy_.solver.once = true;
    if (key == "separate") strategy_.solver.separate = true;
    if (key == "together") strategy_.run.together = true;
    if (key == "reuse") read_reuse(value);
    if (key == "predict") read_predictor(value);
    if (key == "chunks") read_chunks(value);
  }

  void read_reuse(std::string_view value) {
    if (value != "step" && value != "run") refuse(quoted(value) + " is not a kind of reuse: use step or run");
    strategy_.solver.reuse = value == "step" ? Reuse::step : Reuse::run;
  }

  void read_predictor(std::string_view value) {
    const auto [kind, order, has_order] = cut(value, ':');
    for (const PredictorForm& form : kPredictors) {
      if (form.name != kind) continue;
      const auto k = number(order);
      if (k && *k >= form.lowest && *k <= form.highest) {
        strategy_.run.predictor = {form.kind, *k};
        return;
      }
    }
    refuse(quoted(value) + " is not a predictor: use taylor:0, taylor:1, taylor:2, hermite:5 or past:0 to past:5");
  }

  void read_chunks(std::string_view value) {
    const auto chunks = positive(value);
    if (!chunks)
      refuse(quoted(value) + " is not a number of chunks: use 1 to " + std::to_string(std::numeric_limits<int>::max()));
    strategy_.run.chunks = *chunks;
  }

  void read_split(std::string_view text) {
    const Cut split = cut(text, 'x');
    const auto p = positive(split.before), q = positive(split.after);
    if (!p || !q) refuse(quoted(text) + " is not a split PxQ of threads such as 1x1 or 3x2");
    strategy_.run.threads = *p;
    strategy_.solver.threads = *q;
  }

  std::string_view text_;
  Strategy strategy_;
};

}  // namespace

Strategy parse_strategy(std::string_view text) { return Reader(text).read(); }

std::string to_string(const Strategy& s) {
  std::string text = std::string(name(s.run.formulation)) + "/" + s.solver.backend;
  if (s.solver.lanes != 1) text += ":" + std::to_string(s.solver.lanes);
  if (s.solver.single) text += "+float";
  if (s.solver.refine) text += "+refine";
  if (s.solver.reuse == Reuse::step) text += "+reuse=step";
  if (s.solver.reuse == Reuse::run) text += "+reuse=run";
  if (s.solver.once) text += "+once";
  if (s.solver.separate) text += "+separate";
  if (s.run.together) text += "+together";
  for (const PredictorForm& form : kPredictors) {
    if (form.kind != s.run.predictor.kind) continue;
    text += "+predict=" + std::string(form.name) + ":" + std::to_string(s.run.predictor.order);
  }
  if (s.run.chunks != 1) text += "+chunks=" + std::to_string(s.run.chunks);
  if (s.run.threads != 1 || s.solver.threads != 1)
    text += " " + std::to_string(s.run.threads) + "x" + std::to_string(s.solver.threads);
  return text;
}

std::string_view name(Formulation formulation) noexcept {
  switch (formulation) {
    case Formulation::global:
      return "global";
    case Formulation::groups:
      return "groups";
    case Formulation::irreducible:
      return "irreducible";
  }
  return "unknown";
}

}  // namespace assur
