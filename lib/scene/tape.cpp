#include "scene/tape.hpp"

#include <atomic>

namespace assur {

constinit thread_local Tape* Tape::active_ = nullptr;

Tape::Tape() {
  static std::atomic<std::uint64_t> last = 0;
  serial_ = ++last;
}

void Tape::lose(const Number& number, std::string_view why) {
  if (has(number) && lost_.empty()) lost_ = why;
}

// ---- numbers

std::uint64_t Number::record(Operation op, const Number& a, const Number& b, const Number& c) {
  Tape* const tape = Tape::active();
  if (tape == nullptr || !(tape->has(a) || tape->has(b) || tape->has(c))) return 0;
  const std::optional<std::size_t> place = tape->operation(op, a, b, c);
  return place ? tape->number(0, *place).origin_ : 0;
}

void Number::note(const Number& a, const Number& b, bool is_less, bool outcome) {
  Tape* const tape = Tape::active();
  if (tape != nullptr && (tape->has(a) || tape->has(b))) tape->comparison(a, b, is_less, outcome);
}

void Number::lose() const {
  if (Tape* const tape = Tape::active()) {
    tape->lose(*this, "numbers of the scene depend on the values in a way that cannot be repeated without the scene");
  }
}

}  // namespace assur
