// Checks laws and callbacks of the program along a run: at the first step, then at regular intervals.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "assur/report.hpp"
#include "assur/structure.hpp"
#include "equations/differences.hpp"

namespace assur {

// The checks of one run.
class FunctionCheck {
 public:
  // `system` has the given structure; all arguments must outlive the check.
  FunctionCheck(const Structure& structure, const System& system, std::span<const std::int32_t> address);

  // Begins a new run.
  void restart();

  // True if the program gives no functions.
  [[nodiscard]] bool empty() const { return callbacks_.empty() && laws_.empty(); }

  // Checks before a step between two times; state[d]: d-th derivatives of the current posture, by address. Returns an
  // event that names a function that contradicts itself; the next step is then checked, too. asked(input, k): true if
  // the run calls this law of the system. Allocates memory for the event only, and throws nothing.
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
  // Times of the checks. A thorough check costs as much as many quick ones, so that after a thorough check without
  // findings the next check comes later.
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
