// A tape: while it records, it receives how Numbers of a mechanism follow from parameters (Griewank and Walther,
// Evaluating Derivatives, 2008, chapter 4). Each such Number knows its place on the tape; a conversion to double loses
// it, which the tape notes. tables/parameter_tape.hpp computes the numbers again for other values.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "assur/number.hpp"

namespace assur {

class Tape {
 public:
  Tape();
  virtual ~Tape() = default;
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

  // True if the number is on this tape: it follows from the parameters.
  [[nodiscard]] bool has(const Number& number) const { return number.origin_ >> 32 == serial_; }
  // The value of a text of these names, which muParser evaluates.
  [[nodiscard]] virtual Number formula(std::string text, std::vector<std::string> names,
                                       std::span<const Number> arguments, double value) = 0;
  // Notes that a number is used where nothing is recorded.
  void lose(const Number& number, std::string_view why);
  // Why the numbers cannot be computed again; "": they can.
  [[nodiscard]] const std::string& lost() const { return lost_; }

 protected:
  [[nodiscard]] Number number(double value, std::size_t place) const { return {value, serial_ << 32 | place}; }
  // Of a number that is on the tape.
  [[nodiscard]] static std::size_t place_of(const Number& number) { return number.origin_ & 0xffffffff; }

 private:
  friend class Number;
  // Records an operation, of which at least one operand is on the tape. Returns the place of its result; none: it does
  // not depend on the parameters, e.g. a product with 0.
  virtual std::optional<std::size_t> operation(Number::Operation op, const Number& a, const Number& b,
                                               const Number& c) = 0;
  // Records the outcome of a < b (else a == b). With another one the computation would have gone another way.
  virtual void comparison(const Number& a, const Number& b, bool is_less, bool outcome) = 0;

  static constinit thread_local Tape* active_;
  std::uint64_t serial_;  // from 1
  std::string lost_;
};

}  // namespace assur
