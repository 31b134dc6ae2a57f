// Teams: threads that belong to one caller. p callers with a team of q threads each use p x q threads, independently of
// each other; nested regions and tasks of OpenMP do not separate callers in this way. Teams do not use OpenMP, so that
// they work within a parallel region of the caller, and in several threads of the caller with one team each.
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

inline constexpr std::size_t kWorthSharing = 8000;  // pieces of 0.5 ns each: the time of some meetings of two threads

// The calling thread and its helpers.
class Team {
 public:
  // Starts size - 1 threads, which sleep without work, and waits until all of them run.
  //
  // pin_to: processors (Machine::cores). If it is not empty, rank r runs on pin_to[r] only (the caller within run()),
  // and threads that wait in run() busy-wait; use dedicated cores.
  //
  // Throws Error: input if size < 1 or if there are fewer processors to pin to, environment if a thread cannot be
  // started or pinned.
  explicit Team(int size, std::span<const int> pin_to = {});
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  [[nodiscard]] int size() const { return size_; }

  // Calls work(rank) once for each rank 0 to size() - 1, rank 0 on the calling thread, and returns when all are done.
  // One caller at a time, and not from within the work. Takes no lock and allocates no memory.
  //
  // If a member throws, the others end at their next barrier(), and run() throws the exception of the lowest rank. A
  // fork() copies only the calling thread: in the child, the first run() starts new threads, allocates memory, and may
  // throw like the constructor. After a fork() from within the work, the child must not use the team.
  template <class Work>
  void run(Work&& work) {
    if constexpr (std::is_nothrow_invocable_v<Work&, int>) {
      dispatch(work);
    } else {
      dispatch([&](int rank) noexcept {
        try {
          work(rank);
        } catch (const SentHome&) {  // another member has thrown, and its exception is kept
        } catch (...) {
          fail(rank);
        }
      });
      if (barrier_.broken()) rethrow();
    }
  }

  // To be called by all members within run(): returns when all have called it; earlier writes of each member are then
  // visible to all. Throws an exception that run() catches if another member has thrown.
  void barrier() {
    if (!barrier_.arrive_and_wait()) throw SentHome{};
  }

 private:
  using Call = void (*)(const void*, int) noexcept;
  struct SentHome {};
  struct Worker {
    Team* team;
    int rank;
    pthread_t thread;  // the child of a fork() must drop it without joining; std::thread cannot
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
  Call call_ = nullptr;  // null: the workers end
  const void* work_ = nullptr;
  Barrier barrier_;
  alignas(64) std::atomic<std::uint32_t> round_{0};    // advanced by the caller: there is work
  alignas(64) std::atomic<std::uint32_t> working_{0};  // workers that are not done
  alignas(64) std::atomic<std::uint32_t> done_{0};     // advanced by the last worker that is done
  std::vector<Worker> workers_;
  std::vector<std::exception_ptr> thrown_;  // exceptions, by rank
  pid_t process_ = 0;                       // the process in which the workers live
};

}  // namespace assur
