// Solves packs level after level. Packs of one level are independent of each other: threads share them, the longest
// first, if this gains more than a meeting of the threads costs.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "motion/layout.hpp"
#include "parallel/team.hpp"
#include "plan/preparation.hpp"

namespace assur {

// The packs of a layout with their threads.
class Levels {
 public:
  // Starts the threads of the plan, or fewer if no level has work for them, and +together has not. pin_to: see Team.
  Levels(const Preparation& prepared, Layout& layout, std::span<const int> pin_to);

  // Number of threads, including the caller.
  [[nodiscard]] int threads() const { return team_ ? team_->size() : 1; }
  [[nodiscard]] Team* team() { return team_.get(); }  // null: one thread
  // The solver of a pack on the calling thread.
  [[nodiscard]] GroupSolver& solver(const Pack& pack, int rank = 0);
  void restart();
  [[nodiscard]] Effort effort() const;

  // Solves every pack, with the settings attempt(p). expired() is called before each pack; true ends the work with
  // Code::deadline. If packs fail, their level is finished, so that the result does not depend on the threads; `failed`
  // is the first of them.
  template <class AttemptOf, class Expired>
  [[nodiscard]] Status solve(double* const (&state)[3], bool alone, const AttemptOf& attempt, const Expired& expired,
                             Counters& counters, StepErrors& errors, std::size_t& failed);

  // Calls work(pack, solver) for every pack, level after level, on the threads that solve them.
  template <class Work>
  void each(const Work& work);

  // Divides work among all threads if that pays, else calls work(0, 1): work(part, parts) does its part of `pieces`,
  // each of which takes half a nanosecond or more.
  template <class Work>
  void share(std::size_t pieces, const Work& work) {
    if (!team_ || pieces < kWorthSharing) return work(0, 1);
    const auto parts = static_cast<std::size_t>(threads());
    team_->run([&](int rank) { work(static_cast<std::size_t>(rank), parts); });
  }

 private:
  // Work between two meetings: several levels for the calling thread, or one level for all threads.
  struct Phase {
    std::vector<std::int32_t> packs;  // those of thread 0, then of thread 1, ..., each in the order of work
    std::vector<std::int32_t> start;  // threads + 1: index of the first pack of each thread

    [[nodiscard]] std::span<const std::int32_t> of(int rank) const {
      const auto r = static_cast<std::size_t>(rank);
      return std::span(packs).subspan(static_cast<std::size_t>(start[r]),
                                      static_cast<std::size_t>(start[r + 1] - start[r]));
    }
  };
  // The first pack that failed.
  struct Failure {
    std::size_t pack;  // number of packs: none
    Status status;
  };
  struct alignas(64) Share {  // of a thread in one solve()
    Counters counters;
    StepErrors errors;
    Failure failure;
  };
  void schedule(const Plan& plan, int threads);
  template <class AttemptOf, class Expired>
  void work(std::span<const std::int32_t> packs, int rank, double* const (&state)[3], const AttemptOf& attempt,
            const Expired& expired, Counters& counters, StepErrors& errors, Failure& failure);
  template <class AttemptOf, class Expired>
  void work_together(double* const (&state)[3], const AttemptOf& attempt, const Expired& expired);

  std::vector<Pack>& packs_;
  std::vector<std::unique_ptr<GroupSolver>>& solvers_;              // classes; of the calling thread
  std::vector<std::vector<std::unique_ptr<GroupSolver>>> helpers_;  // solvers of each other thread
  std::vector<Phase> phases_;                                       // none: the calling thread solves all packs
  std::vector<std::int32_t> all_;                                   // packs
  std::vector<Share> shares_;                                       // threads
  std::unique_ptr<Team> team_;                                      // null: one thread
  std::atomic<std::size_t> failed_phase_ = 0;                       // number of phases: none
};

template <class AttemptOf, class Expired>
void Levels::work(std::span<const std::int32_t> packs, int rank, double* const (&state)[3], const AttemptOf& attempt,
                  const Expired& expired, Counters& counters, StepErrors& errors, Failure& failure) {
  for (const std::int32_t p : packs) {
    const auto index = static_cast<std::size_t>(p);
    Pack& pack = packs_[index];
    if (!failure.status.ok() && packs_[failure.pack].level != pack.level) return;
    const Status s = expired() ? Status{Code::deadline, Place::group(pack.groups[0]), 0}
                               : solver(pack, rank).solve(pack, state, attempt(index), counters, errors);
    if (!s.ok() && index < failure.pack) failure = {index, s};
  }
}

template <class Work>
void Levels::each(const Work& work) {
  const auto all_of = [&](std::span<const std::int32_t> packs, int rank) {
    for (const std::int32_t p : packs) {
      const auto index = static_cast<std::size_t>(p);
      work(index, solver(packs_[index], rank));
    }
  };
  if (phases_.empty()) return all_of(all_, 0);
  team_->run([&](int rank) {
    for (std::size_t i = 0; i < phases_.size(); ++i) {
      if (i > 0) team_->barrier();
      all_of(phases_[i].of(rank), rank);
    }
  });
}

template <class AttemptOf, class Expired>
void Levels::work_together(double* const (&state)[3], const AttemptOf& attempt, const Expired& expired) {
  for (Share& share : shares_) share = {{}, {}, {packs_.size(), {}}};
  failed_phase_ = phases_.size();
  team_->run([&](int rank) {
    Share& share = shares_[static_cast<std::size_t>(rank)];
    for (std::size_t i = 0; i < phases_.size(); ++i) {
      work(phases_[i].of(rank), rank, state, attempt, expired, share.counters, share.errors, share.failure);
      if (!share.failure.status.ok()) failed_phase_ = i;
      if (i + 1 == phases_.size()) return;
      team_->barrier();
      if (failed_phase_ <= i) return;  // a faster thread may have failed in the next phase already
    }
  });
}

template <class AttemptOf, class Expired>
Status Levels::solve(double* const (&state)[3], bool alone, const AttemptOf& attempt, const Expired& expired,
                     Counters& counters, StepErrors& errors, std::size_t& failed) {
  Failure first{packs_.size(), {}};
  if (alone || phases_.empty()) {
    work(all_, 0, state, attempt, expired, counters, errors, first);
  } else {
    work_together(state, attempt, expired);
    for (const Share& share : shares_) {
      counters += share.counters;
      errors.merge(share.errors);
      if (share.failure.pack < first.pack) first = share.failure;
    }
  }
  failed = first.pack;
  return first.status;
}

}  // namespace assur
