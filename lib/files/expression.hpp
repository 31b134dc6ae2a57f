// Expressions of numbers: "2*crank + 0.1". They may use functions of muParser (angles in rad), the constants pi and e,
// and parameters, but not time.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "assur/number.hpp"

namespace assur {

class Expressions {
 public:
  struct Parameter {
    std::string name;
    std::variant<Number, std::string> value;  // a number or an expression
  };
  struct Finding {
    std::string parameter;
    std::string what;
  };
  // If ok(), `value` is a finite number. Otherwise `what` is the problem; it is empty if the error `follows` from a
  // parameter that was reported already.
  struct Result {
    Number value;
    std::string what;
    bool follows = false;
    [[nodiscard]] bool ok() const { return what.empty() && !follows; }
  };

  Expressions();
  ~Expressions();

  // Evaluates all parameters; to be called once, before evaluate(). Parameters may depend on each other in any order. A
  // parameter that cannot be evaluated counts as broken. `broken`: names of further broken parameters.
  [[nodiscard]] std::vector<Finding> define(const std::vector<Parameter>& parameters,
                                            const std::vector<std::string>& broken = {});

  // `text` without the leading '='.
  [[nodiscard]] Result evaluate(const std::string& text);

 private:
  class Parsers;
  std::unique_ptr<Parsers> parsers_;
};

// An expression that is evaluated many times with other values of its names.
class Formula {
 public:
  // Both must be valid: a text and names that Expressions evaluated.
  Formula(const std::string& text, const std::vector<std::string>& names);
  Formula(Formula&&) noexcept;
  ~Formula();
  // values: of the names.
  [[nodiscard]] double operator()(std::span<const double> values);

 private:
  struct Parser;
  std::unique_ptr<Parser> parser_;
};

}  // namespace assur
