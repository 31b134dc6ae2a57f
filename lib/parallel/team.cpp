#include "parallel/team.hpp"

#include <string>
#include <system_error>

#include "assur/status.hpp"

namespace assur {

Team::Team(int size) {
  if (size < 1) throw Error(Error::Kind::input, "a team needs at least one thread, not " + std::to_string(size));
  try {
    workers_.reserve(static_cast<std::size_t>(size - 1));
    for (int rank = 1; rank < size; ++rank) workers_.emplace_back([this, rank] { serve(rank); });
  } catch (const std::system_error& error) {
    dismiss();
    throw Error(Error::Kind::environment,
                "cannot start " + std::to_string(size - 1) + " threads: " + error.what() + "; use fewer");
  }
}

Team::~Team() { dismiss(); }

void Team::dismiss() {
  call_ = nullptr;
  advance(round_);
  for (std::thread& worker : workers_) worker.join();
  workers_.clear();
}

void Team::dispatch(Call call, const void* work) {
  const auto others = static_cast<std::uint32_t>(workers_.size());
  if (others == 0) return call(work, 0);
  const std::uint32_t before = done_.load(std::memory_order_relaxed);
  call_ = call;
  work_ = work;
  working_.store(others, std::memory_order_relaxed);
  advance(round_);
  call(work, 0);
  wait_while(done_, before);
}

void Team::serve(int rank) {
  for (std::uint32_t seen = 0;; ++seen) {
    wait_while(round_, seen);
    if (!call_) return;
    call_(work_, rank);
    if (working_.fetch_sub(1, std::memory_order_acq_rel) == 1) advance(done_);
  }
}

}  // namespace assur
