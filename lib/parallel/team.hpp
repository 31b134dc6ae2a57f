// A few threads that belong to one caller. p callers with a team of q threads each are p x q threads, and no team knows
// of another: what OpenMP's nested regions and tasks do not keep apart.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>
#include <type_traits>
#include <vector>

#include "parallel/waiting.hpp"

namespace assur {

class Team {
 public:
  // The calling thread and size - 1 of the team's own, which sleep when there is nothing to do. Throws Error (input)
  // if size < 1, Error (environment) if a thread cannot be started.
  explicit Team(int size);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  [[nodiscard]] int size() const { return static_cast<int>(workers_.size()) + 1; }

  // Calls work(rank) once for each rank 0 to size() - 1, rank 0 on the calling thread, and returns when all are done.
  // The calls may wait for each other (Barrier). They must not throw. One caller at a time; takes no lock and no
  // memory.
  template <class Work>
  void run(Work&& work) {
    using W = std::remove_reference_t<Work>;
    static_assert(std::is_nothrow_invocable_v<W&, int>, "the work of a team must be noexcept");
    dispatch([](const void* object, int rank) noexcept { (*static_cast<W*>(const_cast<void*>(object)))(rank); },
             std::addressof(work));
  }

 private:
  using Call = void (*)(const void*, int) noexcept;
  void dispatch(Call call, const void* work);
  void serve(int rank);
  void dismiss();

  Call call_ = nullptr;  // null: the workers go home
  const void* work_ = nullptr;
  alignas(64) std::atomic<std::uint32_t> round_{0};    // advanced by the caller: there is work
  alignas(64) std::atomic<std::uint32_t> working_{0};  // workers that are not done
  alignas(64) std::atomic<std::uint32_t> done_{0};     // advanced by the last worker that is done
  std::vector<std::thread> workers_;
};

}  // namespace assur
