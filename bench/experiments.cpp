#include "experiments.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <utility>

#include "assur/assur.hpp"
#include "backends/backends.hpp"
#include "contenders.hpp"

namespace assur::bench {
namespace {

// Largest difference of two motions with residuals of 8 eps each: proportional to the condition of a group, and for
// accelerations to its square.
constexpr double bound_of(double condition) {
  return 2 * 8 * condition * condition * std::numeric_limits<double>::epsilon();
}
constexpr double kLeg = bound_of(23);   // leg of a Stewart platform: largest over smallest singular value
constexpr double kRing = bound_of(16);  // ring of 6 to 360 points
// chain of ten rockers: each rocker passes on the error of the one before, for accelerations twice
constexpr double kChain = 10 * 10 * bound_of(6);

std::string split(int p, int q) { return " " + std::to_string(p) + "x" + std::to_string(q); }
std::string packs(int p) { return p > 1 ? split(p, 1) : ""; }

std::string rings(const Options& o) { return o.quick ? "rings:legs=16,n=24" : "rings:legs=64,n=120"; }

StepSettings settings(bool pinned) { return {.pin_to = pinned ? this_machine().cores : std::vector<int>{}}; }

// A row of a table. bound: largest difference from a run with other lanes, chunks or threads in a solver; a run with
// other numbers of threads for packs has the same bits.
Entry row(const std::string& scene, const std::string& strategy, std::size_t base = Entry::kItself,
          std::size_t alone = Entry::kItself, double bound = 0) {
  Entry made{scene, strategy};
  made.base = base;
  made.alone = alone;
  made.bound = alone == Entry::kItself || parse_strategy(strategy).solver.threads > 1 ? bound : 0;
  return made;
}

// Adds an entry, with the reason if it cannot run; returns its index.
std::size_t add(std::vector<Entry>& contest, Entry entry, const std::function<std::unique_ptr<Contender>()>& make) {
  try {
    entry.contender = make();
  } catch (const Error& error) {
    entry.failure = std::string("cannot run: ") + error.what();
  }
  contest.push_back(std::move(entry));
  return contest.size() - 1;
}

// One mechanism, step after step: p packs at the same time, q threads in the solver of each.
void add_splits(std::vector<Entry>& contest, const Options& o, const std::string& text, const std::string& strategy,
                double bound) {
  const Scene scene = sample(text);
  int steps = 1;
  const auto add_split = [&](int p, int q, std::size_t alone) {
    const std::string how = strategy + split(p, q);
    return add(contest, row(text, how, alone, alone, bound), [&] {
      return make_steps(scene, {how, o.threads}, steps);
    });
  };
  try {
    steps = steps_in(o.block, scene, strategy);
  } catch (const Error&) {  // the entry has the reason
  }
  const bool parallel = properties_of(parse_strategy(strategy).solver.backend).threads;
  const bool both = strategy.ends_with("team");  // OpenBLAS cannot nest
  const std::size_t alone = add_split(1, 1, Entry::kItself);
  for (const int p : o.counts()) {
    for (const int q : o.counts()) {
      if (p * q == 1 || p * q > o.threads || (q > 1 && !parallel) || (p > 1 && q > 1 && !both)) continue;
      add_split(p, q, alone);
    }
  }
}

std::vector<Entry> latency(const Options& o) {
  std::vector<Entry> contest;
  for (const char* solver : {"lanes:8", "klu", "eigen", "lapack", "team"}) {
    add_splits(contest, o, rings(o), std::string("groups/") + solver, kRing);
  }
  for (const int platforms : o.quick ? std::vector{1, 8} : std::vector{1, 8, 64, 512}) {
    const std::string text = "stewart:platforms=" + std::to_string(platforms);
    for (const char* solver : {"irreducible/lanes:8", "groups/klu"}) add_splits(contest, o, text, solver, kLeg);
  }
  return contest;
}

// One thread, W groups of one mechanism side by side.
std::vector<Entry> lanes(const Options& o) {
  std::vector<Entry> contest;
  const auto sweep = [&](const std::string& text, const std::string& solver, double bound) {
    const Scene scene = sample(text);
    const int steps = steps_in(o.block, scene, solver);
    std::size_t one = Entry::kItself;
    for (const int w : {1, 2, 4, 8, 16}) {
      const std::string strategy = solver + (w > 1 ? ":" + std::to_string(w) : "");
      const std::size_t added = add(contest, row(text, strategy, one, Entry::kItself, bound), [&] {
        return make_steps(scene, {strategy, o.threads}, steps);
      });
      if (w == 1) one = added;
    }
  };
  sweep(rings(o), "groups/lanes", kRing);
  sweep("stewart:legs=64", "groups/lanes", kLeg);
  sweep("stewart:legs=64", "irreducible/lanes", kLeg);
  return contest;
}

const std::vector<std::string> kHandleEnds = {"B1", "B2", "B3", "B4", "B5", "B6"};

// One mechanism over a long time, in chunks that fill lanes and threads.
void add_chunks(std::vector<Entry>& contest, const Options& o, const std::string& text, const Scene& scene,
                double bound) {
  const auto add_run = [&](int count, int p, std::size_t base, std::size_t alone) {
    const std::string strategy =
        "irreducible/lanes:8" + (count > 1 ? "+chunks=" + std::to_string(count) : "") + packs(p);
    return add(contest, row(text, strategy, base, alone, bound), [&] {
      return make_run(scene, {strategy, o.threads});
    });
  };
  const std::size_t whole = add_run(1, 1, Entry::kItself, Entry::kItself);
  for (const int count : {8, 64, 512}) {
    if (o.quick && count > 64) continue;
    const std::size_t alone = add_run(count, 1, whole, Entry::kItself);
    for (const int p : o.counts()) {
      if (p > 1) add_run(count, p, whole, alone);
    }
  }
}

std::vector<Entry> chunks(const Options& o) {
  std::vector<Entry> contest;
  const std::string steps = o.quick ? "steps=400" : "steps=20000";
  // Each level has one group, so that lanes are idle without chunks.
  add_chunks(contest, o, "four_bar:loops=10," + steps, sample("four_bar:loops=10,step=0.01," + steps), kChain);
  add_chunks(contest, o, "stewart:" + steps + ", handle ends", sample("stewart:" + steps).with_outputs(kHandleEnds),
             kLeg);
  return contest;
}

// Many Stewart platforms with different speeds: in lanes and threads, and one by one. wanted: the outputs.
void add_members(std::vector<Entry>& contest, const Options& o, const std::vector<std::string>& wanted) {
  const int members = o.quick ? 64 : 1024, steps = o.quick ? 20 : wanted.empty() ? 50 : 200;
  std::vector<Scene> scenes;
  for (int i = 0; i < members; ++i) {
    Scene scene = sample("stewart", {{"omega", 0.5 + i * 1.0 / members}, {"steps", steps}});
    scenes.push_back(wanted.empty() ? std::move(scene) : scene.with_outputs(wanted));
  }
  const std::string text = "stewart, " + std::string(wanted.empty() ? "everything" : "handle ends");
  const std::size_t base = add(contest, row(text, "irreducible/lanes:8"), [&] {
    return make_members_one_by_one(scenes, {"irreducible/lanes:8", 1});
  });
  for (const char* solver : {"irreducible/lanes:8", "irreducible/lanes:16"}) {
    std::size_t alone = Entry::kItself;
    for (const int p : o.counts()) {
      const std::string strategy = solver + packs(p);
      Entry all = row(text, strategy, base, alone, kLeg);
      all.members = members;
      const std::size_t added = add(contest, std::move(all), [&] {
        return make_ensemble(scenes, {strategy, o.threads});
      });
      if (p == 1) alone = added;
    }
  }
}

std::vector<Entry> members(const Options& o) {
  std::vector<Entry> contest;
  add_members(contest, o, kHandleEnds);
  add_members(contest, o, {});
  return contest;
}

// One platform with increasing numbers of legs.
std::vector<Entry> legs(const Options& o) {
  std::vector<Entry> contest;
  for (int count = 8; count <= (o.quick ? 64 : 4096); count *= 2) {
    const std::string text = "stewart:legs=" + std::to_string(count);
    const Scene scene = sample(text);
    const int steps = steps_in(o.block, scene, "irreducible/lanes:8");
    const auto add_legs = [&](const std::string& strategy, std::size_t base, std::size_t alone) {
      Entry leg = row(text, strategy, base, alone, kLeg);
      leg.legs = count;
      return add(contest, std::move(leg), [&] { return make_steps(scene, {strategy, o.threads}, steps); });
    };
    const std::size_t one = add_legs("irreducible/lanes", Entry::kItself, Entry::kItself);
    const std::size_t alone = add_legs("irreducible/lanes:8", one, Entry::kItself);
    if (o.threads > 1) add_legs("irreducible/lanes:8" + split(o.threads, 1), one, alone);
  }
  return contest;
}

// Runs of increasing numbers of platforms, with the ends of their handles stored.
std::vector<Entry> platforms(const Options& o) {
  std::vector<Entry> contest;
  for (int count = 8; count <= (o.quick ? 64 : 4096); count *= 8) {
    const std::string text = "stewart:platforms=" + std::to_string(count) + ",steps=" + (o.quick ? "20" : "1000");
    std::vector<std::string> ends;
    for (int p = 1; p <= count; ++p) {
      for (const std::string& end : kHandleEnds) ends.push_back(end + "_" + std::to_string(p));
    }
    const Scene scene = sample(text).with_outputs(ends);
    std::size_t alone = Entry::kItself;
    for (const int p : o.counts()) {
      const std::string strategy = "groups/lanes:8" + packs(p);
      Entry run = row(text, strategy, alone, alone);
      run.legs = 6 * count;
      const std::size_t added = add(contest, std::move(run), [&] { return make_run(scene, {strategy, o.threads}); });
      if (p == 1) alone = added;
    }
  }
  return contest;
}

// Steps timed one by one, with free and with pinned threads.
std::vector<Entry> pinned(const Options& o) {
  std::vector<Entry> contest;
  const auto sweep = [&](const std::string& text, const std::string& solver) {
    const Scene scene = sample(text);
    const int steps = std::max(100, steps_in(o.block, scene, solver));
    std::size_t one = Entry::kItself;
    for (const int p : o.counts()) {
      for (const bool pin : {false, true}) {
        const std::string strategy = solver + packs(p);
        Entry timed = row(text, strategy, one, one);
        if (pin) timed.condition = "pinned";
        const std::size_t added = add(contest, std::move(timed), [&] {
          return make_steps(scene, {strategy, o.threads}, steps, settings(pin), true);
        });
        if (one == Entry::kItself) one = added;
      }
    }
  };
  sweep("stewart", "irreducible/lanes:8");
  sweep(rings(o), "groups/lanes:8");
  return contest;
}

// More busy processes than cores: shows that no run hangs, and the cost in time.
std::vector<Entry> crowd(const Options& o) {
  std::vector<Entry> contest;
  const std::string text = rings(o);
  const Scene scene = sample(text);
  const int steps = o.quick ? 10 : 50;  // each step may take a whole time slice of another process
  for (const int p : o.counts()) {
    for (const bool pin : {false, true}) {
      if (pin && p == 1) continue;
      const std::string strategy = "groups/lanes:8" + packs(p);
      const auto make = [&] { return make_steps(scene, {strategy, o.threads}, steps, settings(pin), true); };
      Entry quiet = row(text, strategy), busy = row(text, strategy, contest.size(), contest.size());
      if (pin) quiet.condition = "pinned";
      busy.condition = (pin ? "pinned, " : "") + std::to_string(o.busy) + " busy processes";
      add(contest, std::move(quiet), make);
      add(contest, std::move(busy), [&] { return in_a_crowd(make(), o.busy); });
    }
  }
  return contest;
}

constexpr Experiment kExperiments[] = {
    {"latency", "latency: one mechanism, step after step; p packs at the same time, q threads in each", latency,
     Show::threads},
    {"lanes", "lanes: one thread, W groups side by side", lanes, Show::lanes},
    {"chunks", "chunks: one mechanism over a long time", chunks, Show::chunks},
    {"members", "members: many mechanisms; the first line of each scene is a single mechanism", members, Show::members},
    {"legs", "legs: cost of one leg", legs, Show::legs},
    {"platforms", "platforms: cost of one leg in runs whose handle ends are stored", platforms, Show::legs},
    {"pinned", "pinned: single steps; slowdown relative to one unpinned thread", pinned, Show::single},
    {"crowd", "crowd: among busy processes; slowdown relative to the same run without them", crowd, Show::single},
};

}  // namespace

std::span<const Experiment> experiments() { return kExperiments; }

}  // namespace assur::bench
