// Expressions of numbers: "2*crank + 0.1". muParser's functions in rad, the constants pi and e, parameters; no time.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace assur {

class Expressions {
 public:
  struct Parameter {
    std::string name;
    std::variant<double, std::string> value;  // a number or an expression
  };
  struct Finding {
    std::string parameter;
    std::string what;
  };
  // ok(): `value` is a finite number. Otherwise `what` says what is wrong; it is empty if the value `follows` from a
  // parameter about which a finding was made already.
  struct Result {
    double value = 0;
    std::string what;
    bool follows = false;
    [[nodiscard]] bool ok() const { return what.empty() && !follows; }
  };

  Expressions();
  ~Expressions();

  // Once, before evaluate(). In any order; what cannot be evaluated stays known as broken. `broken`: names of further
  // parameters whose values were found wrong before.
  [[nodiscard]] std::vector<Finding> define(const std::vector<Parameter>& parameters,
                                            const std::vector<std::string>& broken = {});

  // `text` without the leading '='.
  [[nodiscard]] Result evaluate(const std::string& text);

 private:
  class Parsers;
  std::unique_ptr<Parsers> parsers_;
};

}  // namespace assur
