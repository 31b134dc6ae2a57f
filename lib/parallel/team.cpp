#include "parallel/team.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

#include "assur/status.hpp"
#include "parallel/thread_state.hpp"

namespace assur {
namespace {

int checked(int size, std::span<const int> pin_to) {
  if (size < 1) throw Error(Error::Kind::input, "a team needs at least one thread, not " + std::to_string(size));
  if (!pin_to.empty() && pin_to.size() < static_cast<std::size_t>(size)) {
    throw Error(Error::Kind::input, "a team of " + std::to_string(size) + " threads cannot be pinned to " +
                                        std::to_string(pin_to.size()) + " cores; use fewer threads, or do not pin");
  }
  return size;
}

Waiting waiting_of(int size, std::span<const int> pin_to) {
  if (!pin_to.empty()) return Waiting::pinned;
  const std::size_t processors = allowed_processors().size();
  return processors > 0 && static_cast<std::size_t>(size) > processors ? Waiting::crowded : Waiting::shared;
}

}  // namespace

Team::Team(int size, std::span<const int> pin_to)
    : size_(checked(size, pin_to)),
      pin_to_(pin_to.begin(), pin_to.end()),
      waiting_(waiting_of(size, pin_to)),
      barrier_(size, waiting_),
      thrown_(static_cast<std::size_t>(size)) {
  workers_.reserve(static_cast<std::size_t>(size - 1));
  start();
}

Team::~Team() {
  if (process_ == getpid()) dismiss();
}

void Team::start() {
  round_ = 0;
  done_ = 0;
  barrier_.mend();
  workers_.clear();
  process_ = getpid();
  int failure = 0;
  try {
    for (int rank = 1; rank < size_ && failure == 0; ++rank) {
      std::optional<Pinned> there;  // a new thread starts on the processor of its creator
      if (!pin_to_.empty()) there.emplace(pin_to_[static_cast<std::size_t>(rank)]);
      Worker& worker = workers_.emplace_back(Worker{this, rank, {}});
      const auto enter = [](void* self) -> void* {
        static_cast<Worker*>(self)->team->serve(static_cast<Worker*>(self)->rank);
        return nullptr;
      };
      failure = pthread_create(&worker.thread, nullptr, enter, &worker);
      if (failure != 0) workers_.pop_back();
    }
    // A thread may allocate memory while it starts, so all of them start before the caller's work.
    if (failure == 0) run([](int) noexcept {});
  } catch (...) {
    dismiss();
    throw;
  }
  if (failure != 0) {
    dismiss();
    throw Error(Error::Kind::environment,
                "cannot start " + std::to_string(size_ - 1) + " threads: " + std::strerror(failure) + "; use fewer");
  }
}

void Team::dismiss() {
  call_ = nullptr;
  advance(round_);
  for (const Worker& worker : workers_) pthread_join(worker.thread, nullptr);
  workers_.clear();
  process_ = 0;  // the next process that runs this team starts it again
}

void Team::dispatch(Call call, const void* work) {
  if (size_ > 1 && process_ != getpid()) start();
  std::optional<Pinned> here;
  if (!pin_to_.empty()) here.emplace(pin_to_[0]);
  const auto others = static_cast<std::uint32_t>(workers_.size());
  if (others == 0) return call(work, 0);
  const std::uint32_t before = done_.load(std::memory_order_relaxed);
  call_ = call;
  work_ = work;
  working_.store(others, std::memory_order_relaxed);
  advance(round_);
  call(work, 0);
  wait_while(done_, before, waiting_);
}

// While idle, even pinned threads sleep.
void Team::serve(int rank) {
  const Waiting idle = waiting_ == Waiting::pinned ? Waiting::shared : waiting_;
  for (std::uint32_t seen = 0;; ++seen) {
    wait_while(round_, seen, idle);
    if (!call_) return;
    call_(work_, rank);
    if (working_.fetch_sub(1, std::memory_order_acq_rel) == 1) advance(done_);
  }
}

void Team::fail(int rank) {
  thrown_[static_cast<std::size_t>(rank)] = std::current_exception();
  barrier_.break_up();
}

void Team::rethrow() {
  const auto first = std::find_if(thrown_.begin(), thrown_.end(), [](const auto& e) { return e != nullptr; });
  const std::exception_ptr thrown = *first;
  std::fill(thrown_.begin(), thrown_.end(), nullptr);
  barrier_.mend();
  std::rethrow_exception(thrown);
}

}  // namespace assur
