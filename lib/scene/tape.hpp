// A tape: the record of how numbers of a mechanism follow from parameters. It computes them again for other values of
// the parameters, without a scene (Griewank and Walther, Evaluating Derivatives, 2008, chapter 4).
//
// While a tape records, the parameters have values with random last digits. So a double that some code copies still
// tells by its bits which number of the tape it is. A computation in plain double is lost: its result counts as a
// number that does not depend on the parameters. Who uses a tape must therefore compare it with the real computation
// at other values.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

namespace assur {

class Tape {
 public:
  // Place of a number on the tape; kNone: it does not depend on the parameters.
  using Node = std::int32_t;
  static constexpr Node kNone = -1;

  enum class Kind : std::uint8_t {
    parameter,  // a: index of the parameter
    literal,    // a: index into literals()
    add,
    subtract,
    multiply,
    divide,
    negate,
    fused,      // a b + c, rounded once
    root,       // square root
    length,     // (a^2 + b^2 + c^2)^1/2
    magnitude,  // |a|
    angle,      // atan2(a, b)
    formula,    // b: index into formulas()
  };
  struct Operation {
    Kind kind;
    Node a = kNone, b = kNone, c = kNone;
  };
  // A text that muParser evaluates.
  struct Formula {
    std::string text;
    std::vector<std::string> names;
    std::vector<Node> arguments;  // names
  };
  // A comparison that the recorded computation made: a < b (else a == b), with its outcome. With another outcome the
  // computation would have gone another way.
  struct Guard {
    Node a, b;
    bool is_less, outcome;
  };

  // `values` of the parameters, with random last digits.
  explicit Tape(std::span<const double> values);
  Tape(const Tape&) = delete;
  Tape& operator=(const Tape&) = delete;

  // The tape that records on this thread; null: none.
  [[nodiscard]] static Tape* active() { return active_; }
  // Makes a tape the active one, for a scope; null: nothing is recorded there.
  class Recording {
   public:
    explicit Recording(Tape* tape) : before_(active_) { active_ = tape; }
    ~Recording() { active_ = before_; }
    Recording(const Recording&) = delete;
    Recording& operator=(const Recording&) = delete;

   private:
    Tape* before_;
  };

  // The node of a double, by its bits.
  [[nodiscard]] Node find(double value) const {
    const auto found = node_of_.find(std::bit_cast<std::uint64_t>(value));
    return found == node_of_.end() ? kNone : found->second;
  }
  // Records an operation and its result. Operands that are not on the tape become literals.
  Node record(Kind kind, double result, const Operation& operands);
  Node literal(double value);
  void compare(const Guard& guard) { guards_.push_back(guard); }
  // Records a formula unless its result is known already.
  void record(Formula formula, double result);

  [[nodiscard]] std::span<const Operation> operations() const { return operations_; }
  [[nodiscard]] std::span<const double> literals() const { return literals_; }
  [[nodiscard]] std::span<const Formula> formulas() const { return formulas_; }
  [[nodiscard]] std::span<const Guard> guards() const { return guards_; }
  [[nodiscard]] std::size_t parameters() const { return parameters_; }

 private:
  Node add(const Operation& operation, double result);

  static constinit thread_local Tape* active_;
  std::size_t parameters_;
  std::vector<Operation> operations_;
  std::vector<double> literals_;
  std::vector<Formula> formulas_;
  std::vector<Guard> guards_;
  std::unordered_map<std::uint64_t, Node> node_of_;     // by the bits of the value
  std::unordered_map<std::uint64_t, Node> literal_of_;  // by the bits of the value
};

}  // namespace assur
