// A control loop on Linux: the pose of a platform from the lengths of its six legs, 1,000 times a second, each time
// within 0.5 ms. It shows how a program keeps deadlines. It prints how long the steps took, how many were late, and how
// many of these were late because of the scheduler.
//
//   control [SECONDS [PROCESSOR]]
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <time.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

#include <assur/assur.hpp>

namespace {

constexpr double kPeriod = 1e-3, kDeadline = 0.5e-3;  // s
constexpr int kFirstSteps = 2000, kLegs = 6;

double seconds_of(const timespec& t) { return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec); }

double now(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return seconds_of(t);
}

// Number of times that the scheduler took the processor from this thread, and number of its page faults.
struct Interruptions {
  long switches = 0, faults = 0;

  static Interruptions so_far() {
    rusage usage{};
    getrusage(RUSAGE_THREAD, &usage);
    return {usage.ru_nivcsw, usage.ru_minflt + usage.ru_majflt};
  }
};

// One turn of the loop; times in s.
struct Turn {
  double waking = 0;        // delay by the scheduler until the thread ran
  double end = 0;           // end of the step, from the time of the turn
  double step = 0;          // time of the step by the wall clock
  double own = 0;           // processor time of the step
  std::int64_t passed = 0;  // earlier turns that passed before the thread woke
  bool slow = false;        // this step took too long, or the step before took so long that no time was left

  [[nodiscard]] bool late() const { return end > kDeadline; }
};

void say(const char* what, int error) { std::printf("  %-28s %s\n", what, error == 0 ? "yes" : std::strerror(error)); }

// Settings that keep the system from stopping this thread. The system may refuse each of them; the loop runs
// nevertheless.
void take_care(int processor) {
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(static_cast<std::size_t>(processor), &one);
  say("pinned to its processor", pthread_setaffinity_np(pthread_self(), sizeof one, &one));
  sched_param priority{};
  priority.sched_priority = 80;
  say("real-time priority", pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority));
  prctl(PR_SET_TIMERSLACK, 1UL);  // ns; otherwise a thread without real-time priority is woken 50 us late
  say("memory locked", mlockall(MCL_CURRENT | MCL_FUTURE) == 0 ? 0 : errno);
}

// Joints on a circle, in pairs; m.
assur::Triple joint(double radius, double turned, int leg) {
  const double angle = turned + 2 * std::numbers::pi / 3 * (leg / 2) + (leg % 2 == 0 ? -0.2 : 0.2);
  return {radius * std::cos(angle), radius * std::sin(angle), 0};
}

double length_at_rest(int leg) {
  const assur::Triple a = joint(1, 0, leg), b = joint(0.5, leg % 2 == 0 ? -0.8 : 0.8, leg);
  return std::hypot(a[0] - b[0], a[1] - b[1], 1);
}

// A platform 1 m above its base, on six legs whose lengths are driven.
assur::Scene hexapod() {
  assur::SceneBuilder scene("hexapod", 3);
  scene.point("O", {0, 0, 1}).vector("u", {1, 0, 0}).vector("v", {0, 1, 0}).vector("w", {0, 0, 1});
  assur::Body platform{"platform", "O", {"u", "v", "w"}, {}, {}, {}};
  for (int leg = 0; leg < kLegs; ++leg) {
    const std::string number = std::to_string(leg + 1);
    scene.fixed_point("A" + number, joint(1, 0, leg));
    platform.points.push_back({"B" + number, joint(0.5, leg % 2 == 0 ? -0.8 : 0.8, leg)});
    scene.drive("leg" + number,
                assur::DrivenDistance{"A" + number, "B" + number, assur::Law::constant(length_at_rest(leg))});
  }
  return scene.add(std::move(platform)).output("O").output("u").time(0, 1, kPeriod).build();
}

// Lengths and rates of the legs at time t (s), as a robot would report them.
void measure_legs(double t, const std::vector<std::string>& legs, assur::Simulator& platform) {
  for (int leg = 0; leg < kLegs; ++leg) {
    const double omega = 2 * std::numbers::pi * (0.3 + 0.1 * leg), amplitude = 0.03;  // rad/s, m
    platform.set(legs[static_cast<std::size_t>(leg)], length_at_rest(leg) + amplitude * std::sin(omega * t),
                 amplitude * omega * std::cos(omega * t));
  }
}

void sleep_until(double time) {
  timespec t{};
  t.tv_sec = static_cast<time_t>(time);
  t.tv_nsec = static_cast<long>(1e9 * (time - static_cast<double>(t.tv_sec)));
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
  }
}

void print(const char* what, std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const auto rank = [&](double share) {
    return 1e6 * values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
  };
  std::printf("  %-28s p50 %8.1f   p99 %8.1f   p99.9 %8.1f   worst %8.1f us\n", what, rank(0.5), rank(0.99),
              rank(0.999), rank(1));
}

}  // namespace

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 10;
  const int processor = argc > 2 ? std::atoi(argv[2]) : sched_getcpu();
  const auto turns = static_cast<std::size_t>(seconds / kPeriod);
  if (turns < 1 || processor < 0 || processor >= CPU_SETSIZE) {
    std::fprintf(stderr, "usage: control [SECONDS [PROCESSOR]]\n");
    return 2;
  }

  // Work that takes long or allocates memory comes first.
  const std::vector<std::string> legs = {"leg1", "leg2", "leg3", "leg4", "leg5", "leg6"};
  assur::Simulator platform(assur::prepare(hexapod(), {.controlled = legs, .budget = assur::ThreadBudget{1}}),
                            {.seconds = kDeadline});
  const std::size_t z = 2;  // index in platform.outputs(): the height of O
  std::vector<Turn> done;
  done.reserve(turns);

  std::printf("%g s at %g Hz on processor %d, deadline %g us\n", seconds, 1 / kPeriod, processor, 1e6 * kDeadline);
  take_care(processor);

  // The first steps access all pages, fill the caches, and move the simulator to the first command.
  const assur::SimulatorState start = platform.save();
  for (int k = 0; k < kFirstSteps; ++k) {
    measure_legs(kPeriod * k, legs, platform);
    (void)platform.step().arrived();  // with cold caches it may miss its deadline
  }
  platform.restore(start);

  // A turn begins at its own time, however long the last turn took. Turns that have passed are skipped.
  const Interruptions before = Interruptions::so_far();
  std::size_t failed = 0;
  double sum = 0, end = 0;
  const double start_time = now(CLOCK_MONOTONIC) + kPeriod;
  for (std::size_t k = 0; k < turns; ++k) {
    double turn_time = start_time + kPeriod * static_cast<double>(k);
    sleep_until(turn_time);
    const double own = now(CLOCK_THREAD_CPUTIME_ID), begin = now(CLOCK_MONOTONIC);
    Turn turn;
    turn.waking = begin - std::max(turn_time, end);
    turn.slow = end > turn_time && done.back().slow;
    turn.passed = static_cast<std::int64_t>((begin - turn_time) / kPeriod);
    k += static_cast<std::size_t>(turn.passed);
    turn_time += kPeriod * static_cast<double>(turn.passed);
    measure_legs(turn_time - start_time, legs, platform);
    const assur::Status status = platform.step();
    if (status.arrived()) sum += platform.outputs()[z];  // else the last outputs remain in use until the next turn
    end = now(CLOCK_MONOTONIC);
    turn.step = end - begin;
    turn.end = end - turn_time;
    turn.own = now(CLOCK_THREAD_CPUTIME_ID) - own;
    turn.slow = turn.slow || turn.own > kDeadline;
    done.push_back(turn);
    if (!status.arrived()) ++failed;
  }
  const Interruptions after = Interruptions::so_far();

  std::vector<double> waking, step, own;
  std::int64_t slow = 0, not_woken = 0, stopped = 0;  // numbers of late turns
  for (const Turn& turn : done) {
    waking.push_back(turn.waking);
    step.push_back(turn.step);
    own.push_back(turn.own);
    std::int64_t& passed_by = turn.slow ? slow : not_woken;
    passed_by += turn.passed;
    if (turn.late()) ++(turn.slow ? slow : turn.end - turn.step + turn.own > kDeadline ? not_woken : stopped);
  }
  print("woken late by", waking);
  print("a step, by the wall clock", step);
  print("a step, processor time", own);
  std::printf("  %-28s %ld times; %ld page faults\n", "interrupted by the scheduler", after.switches - before.switches,
              after.faults - before.faults);
  std::printf("  %-28s %lld of %zu: %lld woken too late, %lld stopped within the step, %lld by the step itself\n",
              "deadlines missed", static_cast<long long>(slow + not_woken + stopped), turns,
              static_cast<long long>(not_woken), static_cast<long long>(stopped), static_cast<long long>(slow));
  std::printf("  %-28s %zu; mean height %.6f m\n", "steps without a result", failed,
              sum / static_cast<double>(done.size() - failed));
  return 0;
}
