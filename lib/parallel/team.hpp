// A few threads that belong to one caller. p callers with a team of q threads each are p x q threads, and no team knows
// of another: what OpenMP's nested regions and tasks do not keep apart. A team knows nothing of OpenMP: it can be used
// within a parallel region of the caller's, and from several threads of the caller's with one team each.
#pragma once

#include <pthread.h>
#include <sys/types.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

#include "parallel/barrier.hpp"
#include "parallel/waiting.hpp"

namespace assur {

inline constexpr std::size_t kWorthSharing = 8000;  // pieces of half a nanosecond: some meetings of two threads

class Team {
 public:
  // The calling thread and size - 1 of the team's own, which sleep when there is nothing to do.
  //
  // pin_to: processors (one of each core: Machine::cores). If not empty, rank r runs on pin_to[r] alone, the caller
  // only within run(); who waits in run() then spins and never sleeps. For cores that nobody else needs.
  //
  // Throws Error: input if size < 1 or if there are fewer processors to pin to, environment if a thread cannot be
  // started or pinned.
  explicit Team(int size, std::span<const int> pin_to = {});
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  [[nodiscard]] int size() const { return size_; }

  // Calls work(rank) once for each rank 0 to size() - 1, rank 0 on the calling thread, and returns when all are done.
  // One caller at a time, and not from within the work; takes no lock and no memory.
  //
  // If a member throws, the others are sent home at their next barrier(), and run() throws what the lowest rank threw.
  // In the child of a fork() the first run() starts threads anew, since a fork takes none along but its caller: then it
  // takes memory and may throw as the constructor does. A fork() from within the work leaves the child no team.
  template <class Work>
  void run(Work&& work) {
    if constexpr (std::is_nothrow_invocable_v<Work&, int>) {
      dispatch(work);
    } else {
      dispatch([&](int rank) noexcept {
        try {
          work(rank);
        } catch (const SentHome&) {  // what another member threw is known
        } catch (...) {
          fail(rank);
        }
      });
      if (barrier_.broken()) rethrow();
    }
  }

  // Within run(), to be called by all members: returns when all are here; what each wrote before is then seen by all.
  // Throws (for run() to catch) if a member has thrown and will not come.
  void barrier() {
    if (!barrier_.arrive_and_wait()) throw SentHome{};
  }

 private:
  using Call = void (*)(const void*, int) noexcept;
  struct SentHome {};
  struct Worker {
    Team* team;
    int rank;
    pthread_t thread;  // std::thread cannot be forgotten, which the child of a fork() must do
  };

  template <class Work>
  void dispatch(Work&& work) {
    using W = std::remove_reference_t<Work>;
    dispatch([](const void* object, int rank) noexcept { (*static_cast<W*>(const_cast<void*>(object)))(rank); },
             std::addressof(work));
  }
  void dispatch(Call call, const void* work);
  void start();
  void dismiss();
  void serve(int rank);
  void fail(int rank);
  [[noreturn]] void rethrow();

  const int size_;
  const std::vector<int> pin_to_;
  const Waiting waiting_;
  Call call_ = nullptr;  // null: the workers go home
  const void* work_ = nullptr;
  Barrier barrier_;
  alignas(64) std::atomic<std::uint32_t> round_{0};    // advanced by the caller: there is work
  alignas(64) std::atomic<std::uint32_t> working_{0};  // workers that are not done
  alignas(64) std::atomic<std::uint32_t> done_{0};     // advanced by the last worker that is done
  std::vector<Worker> workers_;
  std::vector<std::exception_ptr> thrown_;  // by each rank
  pid_t process_ = 0;                       // in which the workers live
};

}  // namespace assur
