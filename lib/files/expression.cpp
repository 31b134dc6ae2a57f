#include "files/expression.hpp"

#include <muParser.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <unordered_map>
#include <unordered_set>

#include "scene/names.hpp"
#include "scene/tape.hpp"

namespace assur {
namespace {

constexpr std::size_t kLongestParameter = 100;  // muParser takes no longer name

void prepare(mu::Parser& parser) {
  parser.ClearConst();  // muParser defines _pi and _e
  parser.DefineConst("pi", std::numbers::pi);
  parser.DefineConst("e", std::numbers::e);
}

std::string unreadable(const std::string& text, const mu::Parser::exception_type& error) {
  std::string reason = error.GetMsg();
  // positions are those of muParser's own buffer
  for (const std::string_view tail : {" found at position", " at position", "."}) {
    if (const std::size_t at = reason.rfind(tail); at != std::string::npos) reason.resize(at);
  }
  if (!reason.empty() && reason.front() >= 'A' && reason.front() <= 'Z') reason.front() += 'a' - 'A';
  return in_quotes("=" + text) + " cannot be read: " + excerpt(reason);
}

}  // namespace

class Expressions::Parsers {
 public:
  std::unordered_map<std::string, Result> evaluated;  // large scenes repeat few expressions

  Parsers() {
    prepare(names_);
    prepare(values_);
  }

  [[nodiscard]] bool is_reserved(const std::string& name) const {
    return name == "pi" || name == "e" || values_.GetFunDef().count(name) != 0;
  }

  // Names in `text` that are not functions or constants. Throws muParser's error if the text cannot be read.
  [[nodiscard]] std::vector<std::string> names(const std::string& text) {
    names_.SetExpr(text);
    std::vector<std::string> used;
    for (const auto& [name, unused] : names_.GetUsedVar()) used.push_back(name);
    return used;
  }

  void set(const std::string& name, const Number& value) {
    values_.DefineConst(name, value.value());
    known_.insert(name);
    value_of_.emplace(name, value);
  }

  void set_broken(const std::string& name) {
    known_.insert(name);
    broken_.insert(name);
  }

  void announce(const std::vector<Parameter>& parameters) {
    for (const Parameter& p : parameters) announced_.push_back(p.name);
  }

  [[nodiscard]] Result evaluate(const std::string& text) {
    try {
      values_.SetExpr(text);
      int results = 0;
      const double value = values_.Eval(results)[0];
      if (results != 1) {
        return {0, in_quotes("=" + text) + " gives " + std::to_string(results) + " numbers; one is wanted", false};
      }
      if (!std::isfinite(value)) {
        return {0, in_quotes("=" + text) + " is " + shortest(value) + "; a finite number is wanted", false};
      }
      return {with_origin(text, value), "", false};
    } catch (const mu::Parser::exception_type& error) {
      return explain(text, error);
    }
  }

 private:
  // The value of an expression, recorded if it uses numbers of the active tape.
  [[nodiscard]] Number with_origin(const std::string& text, double value) {
    Tape* const tape = Tape::active();
    if (tape == nullptr) return value;
    std::vector<std::string> used = names(text);
    std::vector<Number> arguments;
    for (const std::string& name : used) arguments.push_back(value_of_.at(name));
    const bool follows = std::any_of(arguments.begin(), arguments.end(), [&](const Number& a) { return tape->has(a); });
    return follows ? tape->formula(text, std::move(used), arguments, value) : Number(value);
  }

  // The first word before a parenthesis that is not a function; "" if there is none.
  std::string unknown_function(const std::string& text) const {
    for (std::size_t open = text.find('('); open != std::string::npos; open = text.find('(', open + 1)) {
      const std::size_t end = text.find_last_not_of(" \t", open - 1);
      if (open == 0 || end == std::string::npos) continue;
      std::size_t begin = end + 1;
      while (begin > 0 && is_name("_" + text.substr(begin - 1, 1))) --begin;
      const std::string word = text.substr(begin, end + 1 - begin);
      if (is_name(word) && values_.GetFunDef().count(word) == 0) return word;
    }
    return "";
  }

  std::string parameter_near(const std::string& name) {
    if (suggestions_left_-- <= 0) return "";
    return suggestion(name, {announced_.begin(), announced_.end()});
  }

  Result explain(const std::string& text, const mu::Parser::exception_type& error) {
    if (text.find_first_not_of(" \t\r\n") == std::string::npos) return {0, "an expression is missing after '='", false};
    if (const std::string function = unknown_function(text); !function.empty()) {
      std::vector<std::string_view> functions;
      for (const auto& [name, unused] : values_.GetFunDef()) functions.push_back(name);
      return {0, "there is no function " + in_quotes(function) + suggestion(function, functions), false};
    }
    try {
      bool follows = false;
      for (const std::string& name : names(text)) {
        follows = follows || broken_.count(name) != 0;
        if (known_.count(name) != 0) continue;
        const std::string time = name == "t" ? "; expressions do not depend on time, laws do" : "";
        return {0, "there is no parameter " + in_quotes(name) + (time.empty() ? parameter_near(name) : time), false};
      }
      if (follows) return {0, "", true};
    } catch (const mu::Parser::exception_type& unreadable_error) {
      return {0, unreadable(text, unreadable_error), false};
    }
    return {0, unreadable(text, error), false};
  }

  mu::Parser names_;   // knows no parameters, so every name is unknown
  mu::Parser values_;  // has the parameters as constants
  std::unordered_set<std::string> known_, broken_;
  std::unordered_map<std::string, Number> value_of_;
  std::vector<std::string> announced_;
  int suggestions_left_ = 100;  // each compares all parameters
};

Expressions::Expressions() : parsers_(std::make_unique<Parsers>()) {}
Expressions::~Expressions() = default;

Expressions::Result Expressions::evaluate(const std::string& text) {
  const auto [found, is_new] = parsers_->evaluated.try_emplace(text);
  if (is_new) found->second = parsers_->evaluate(text);
  return found->second;
}

struct Formula::Parser {
  mu::Parser parser;
  std::vector<double> values;
};

Formula::Formula(const std::string& text, const std::vector<std::string>& names) : parser_(std::make_unique<Parser>()) {
  prepare(parser_->parser);
  // The optimiser changes the order of operations on variables, so that results would differ in their last bits.
  parser_->parser.EnableOptimizer(false);
  parser_->values.resize(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) parser_->parser.DefineVar(names[i], &parser_->values[i]);
  parser_->parser.SetExpr(text);
}
Formula::Formula(Formula&&) noexcept = default;
Formula::~Formula() = default;

double Formula::operator()(std::span<const double> values) {
  std::copy(values.begin(), values.end(), parser_->values.begin());
  return parser_->parser.Eval();
}

// A parameter is evaluated after all parameters that it uses. The rest are on a cycle, or depend on one.
std::vector<Expressions::Finding> Expressions::define(const std::vector<Parameter>& parameters,
                                                      const std::vector<std::string>& broken) {
  std::vector<Finding> findings;
  const std::size_t n = parameters.size();
  std::unordered_map<std::string, std::size_t> index;
  for (std::size_t i = 0; i < n; ++i) index.emplace(parameters[i].name, i);
  parsers_->announce(parameters);
  for (const std::string& name : broken) parsers_->set_broken(name);

  std::vector<std::vector<std::size_t>> uses(n), users(n);
  std::vector<std::size_t> open(n, 0), ready;
  std::vector<bool> done(n, false);
  const auto find_wrong = [&](std::size_t i, std::string what) {
    findings.push_back({parameters[i].name, std::move(what)});
    parsers_->set_broken(parameters[i].name);
  };
  for (std::size_t i = 0; i < n; ++i) {
    if (parsers_->is_reserved(parameters[i].name)) {
      findings.push_back({parameters[i].name, in_quotes(parameters[i].name) +
                                                  " is a constant or function of expressions; choose another name"});
      done[i] = true;
      continue;
    }
    if (const auto* text = std::get_if<std::string>(&parameters[i].value)) {
      try {
        for (const std::string& name : parsers_->names(*text)) {
          const auto used = index.find(name);
          if (used == index.end()) continue;  // evaluate() reports it
          uses[i].push_back(used->second);
          users[used->second].push_back(i);
          ++open[i];
        }
      } catch (const mu::Parser::exception_type& error) {
        // evaluate() reports it
      }
    }
    if (open[i] == 0) ready.push_back(i);
  }

  while (!ready.empty()) {
    const std::size_t i = ready.back();
    ready.pop_back();
    done[i] = true;
    if (parameters[i].name.size() > kLongestParameter) {
      find_wrong(i, in_quotes(parameters[i].name) + " is too long for a parameter: 100 characters at most");
    } else if (const auto* text = std::get_if<std::string>(&parameters[i].value)) {
      const Result result = parsers_->evaluate(*text);
      if (result.ok()) {
        parsers_->set(parameters[i].name, result.value);
      } else if (result.follows) {
        parsers_->set_broken(parameters[i].name);
      } else {
        find_wrong(i, result.what);
      }
    } else {
      parsers_->set(parameters[i].name, std::get<Number>(parameters[i].value));
    }
    for (const std::size_t user : users[i]) {
      if (--open[user] == 0) ready.push_back(user);
    }
  }

  const auto next = [&](std::size_t i) {  // the first parameter that i uses and that could not be evaluated
    return *std::find_if(uses[i].begin(), uses[i].end(), [&](std::size_t used) { return !done[used]; });
  };
  std::vector<std::size_t> visit(n, n);  // start of the walk that visited the parameter, n: none
  for (std::size_t start = 0; start < n; ++start) {
    if (done[start]) continue;
    parsers_->set_broken(parameters[start].name);
    std::size_t i = start;
    for (; visit[i] == n; i = next(i)) visit[i] = start;
    if (visit[i] != start) continue;    // leads to a cycle that is reported already
    constexpr std::size_t kShown = 10;  // names; a choice
    std::string circle = excerpt(parameters[i].name);
    std::size_t first = i, length = 1;
    for (std::size_t j = next(i); j != i; j = next(j), ++length) {
      if (length < kShown) circle += " -> " + excerpt(parameters[j].name);
      first = std::min(first, j);
    }
    if (length > kShown) circle += " -> (" + std::to_string(length - kShown) + " more)";
    circle += " -> " + excerpt(parameters[i].name);
    findings.push_back({parameters[first].name, "parameters define each other in a circle: " + circle});
  }
  return findings;
}

}  // namespace assur
