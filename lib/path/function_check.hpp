// Laws and callbacks of the program, checked now and then on the way: at the first step, then at every so many of them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "assur/report.hpp"
#include "assur/structure.hpp"
#include "scene/differences.hpp"

namespace assur {

class FunctionCheck {
 public:
  // Of a system that has the given structure; both, and the addresses, must outlive it.
  FunctionCheck(const Structure& structure, const System& system, std::span<const std::int32_t> address);

  void restart();

  // Nothing is of the program.
  [[nodiscard]] bool empty() const { return callbacks_.empty() && laws_.empty(); }

  // Before a step between two times, from the posture with the derivatives state[d], by address: an event that names
  // what contradicts itself; then the next step is checked, too. asked(input, k): is that law of the system asked?
  // Allocates nothing but for the event, and throws nothing.
  template <class Asked>
  [[nodiscard]] std::optional<Event> before_step(double from, double to, const double* const (&state)[3],
                                                 const Asked& asked) {
    for (OfCallback& c : callbacks_) {
      if (c.when.due(steps_) && contradicts(c, state)) return event(c, from, to);
    }
    for (OfLaw& l : laws_) {
      if (l.when.due(steps_) && asked(l.input, l.k) && contradicts(l, from, to)) return event(l, from, to);
    }
    ++steps_;
    return std::nullopt;
  }

 private:
  // A closer look costs as much as many cheap ones: where it was needlessly taken, the next is later.
  struct Schedule {
    std::int64_t interval, next = 0;

    [[nodiscard]] bool due(std::int64_t step) const { return step >= next; }
    void passed(std::int64_t step, bool closely);
  };
  struct OfCallback {
    const CallbackBlock* block;
    CallbackCheck check;
    bool curvature;
    Schedule when;
  };
  struct OfLaw {
    std::size_t input, k;
    const Law::Function* law;
    double unit;
    Schedule when;
  };
  void add_callback(const Structure& structure, const CallbackBlock& block);
  [[nodiscard]] bool contradicts(OfCallback& c, const double* const (&state)[3]);
  [[nodiscard]] bool contradicts(OfLaw& l, double from, double to);
  [[nodiscard]] Event event(const OfCallback& c, double from, double to) const;
  [[nodiscard]] Event event(const OfLaw& l, double from, double to) const;

  const System& system_;
  std::span<const std::int32_t> address_;
  std::vector<OfCallback> callbacks_;
  std::vector<OfLaw> laws_;
  LawCheck law_check_;
  int derivatives_ = 0;
  std::int64_t steps_ = 0;
  std::optional<Contradiction> found_;
};

}  // namespace assur
