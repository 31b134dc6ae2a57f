#include "measure/motion.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "drivers/inputs.hpp"
#include "evaluation/evaluator.hpp"
#include "index.hpp"
#include "measure/postures.hpp"
#include "motion/layout.hpp"
#include "motion/together.hpp"
#include "parallel/thread_state.hpp"
#include "plan/preparation.hpp"

namespace assur::measure {
namespace {

constexpr std::size_t kWorthWarming = 20000;     // packs x unknowns x W up to which an untimed round warms up
constexpr double kFirstOff = 1e-8;               // relative error of a prediction; one iteration leaves its square
constexpr double kLeastOff = 1e-12;              // still far above the criterion of convergence
constexpr std::int64_t kStepsBeforeSteady = 10;  // steps until predictors have all their postures

class Evaluation final : public Workload {
 public:
  Evaluation(std::shared_ptr<const GroupedSystem> structure, std::int32_t group_class, int lanes)
      : structure_(std::move(structure)),
        class_(structure_->classes[idx(group_class)]),
        evaluator_(make_evaluator(*structure_->system, class_, lanes)) {
    std::vector<Posture> postures;
    for (const SolvedGroup& group : structure_->groups) {
      if (group.group_class == group_class && static_cast<int>(postures.size()) < lanes) {
        postures.push_back(posture(*structure_, class_, group));
      }
    }
    const auto side_by_side = [&](std::vector<double> Posture::*what) {
      const std::size_t rows = (postures[0].*what).size(), w = static_cast<std::size_t>(lanes);
      std::vector<double> out(rows * w);
      for (std::size_t i = 0; i < out.size(); ++i) out[i] = (postures[i % w % postures.size()].*what)[i / w];
      return out;
    };
    coefficients_ = side_by_side(&Posture::coefficients);
    // A pack has the numbers 0 and 1 after the coefficients of the program.
    coefficients_.resize(coefficients_.size() + static_cast<std::size_t>(lanes), 0.0);
    coefficients_.resize(coefficients_.size() + static_cast<std::size_t>(lanes), 1.0);
    inputs_ = side_by_side(&Posture::inputs);
    unknowns_ = side_by_side(&Posture::unknowns);
    phi_.resize(unknowns_.size());
    jacobian_.resize(class_.pattern.row.size() * static_cast<std::size_t>(lanes));
  }

  void get_ready(int) override { (void)run(1); }
  bool run(int calls) override {
    for (int i = 0; i < calls; ++i) {
      evaluator_->set_inputs(coefficients_.data(), inputs_.data());
      evaluator_->evaluate(unknowns_.data(), phi_.data(), jacobian_.data());
    }
    return std::isfinite(phi_[0]);
  }

 private:
  std::shared_ptr<const GroupedSystem> structure_;
  const GroupClass& class_;
  std::unique_ptr<Evaluator> evaluator_;
  std::vector<double> coefficients_, inputs_, unknowns_, phi_, jacobian_;
};

}  // namespace

std::unique_ptr<Workload> evaluation(std::shared_ptr<const GroupedSystem> structure, std::int32_t group_class,
                                     int lanes) {
  return std::make_unique<Evaluation>(std::move(structure), group_class, lanes);
}

// ---- pack

struct PackStep::Impl {
  Impl(const Prepared& p, std::int32_t group_class)
      : prepared(p), layout(lay_out(preparation(prepared))), solver(*layout.solvers[idx(group_class)]) {
    const bool all_classes = prepared.plan().run.together;
    for (std::vector<double>& s : state) s.resize(layout.size);
    for (const auto& s : layout.solvers) {
      if (preparation(prepared).code != nullptr && !all_classes) s->use(*preparation(prepared).code);
    }
    solve_start();
    for (Pack& pack : layout.packs) {
      if (all_classes || pack.group_class == group_class) packs.push_back(&pack);
    }
    if (all_classes) {
      together = std::make_unique<Together>(preparation(prepared), layout, nullptr);
      if (preparation(prepared).code != nullptr) together->use(*preparation(prepared).code);
      together->start({at(0), at(1), at(2)});
    }
    lanes = all_classes ? prepared.plan().choices[idx(group_class)].solver.lanes : solver.lanes();
    of_class = static_cast<std::size_t>(
        std::count_if(packs.begin(), packs.end(), [&](const Pack* pack) { return pack->group_class == group_class; }));
    // With +together each group is a pack of the layout.
    if (all_classes) of_class = (of_class + idx(lanes) - 1) / idx(lanes);
    for (double off = kFirstOff; off >= kLeastOff; off /= 10) {
      predict(off);
      if (takes_one_iteration()) return;
    }
    throw Error(Error::Kind::numerical, "no prediction is solved in exactly one iteration");
  }

  [[nodiscard]] double* at(int d) { return state[static_cast<std::size_t>(d)].data(); }

  // Solves the start posture like a simulator; all predictions start from it.
  void solve_start() {
    const GroupedSystem& structure = *preparation(prepared).structure;
    double* const q[3] = {at(0), at(1), at(2)};
    for (std::size_t c = 0; c < layout.address.size(); ++c) {
      if (layout.address[c] >= 0) q[0][layout.address[c]] = structure.start[c];
    }
    Inputs inputs(*structure.system, prepared.controlled());
    Status status = inputs.drive(preparation(prepared).start_time.value_or(prepared.scene()->time().start), q);
    for (const auto& s : layout.solvers) s->restart();
    Attempt attempt;
    attempt.branch = Attempt::Branch::start;
    attempt.makes_code = true;
    for (Pack& pack : layout.packs) {
      if (!status.ok()) break;
      repeat_lane_0(pack, q[0]);
      status = layout.solvers[idx(pack.group_class)]->solve(pack, q, attempt, counters, errors);
    }
    if (!status.ok()) {
      throw Error(Error::Kind::numerical, "the start posture has no solution: " + std::string(name(status.code)));
    }
  }

  void repeat_lane_0(const Pack& pack, double* q) const {
    const GroupSolver& s = *layout.solvers[idx(pack.group_class)];
    const auto w = static_cast<std::size_t>(s.lanes());
    for (std::size_t i = 0; i < idx(s.group_class().n); ++i) {
      double* x = q + pack.unknowns + i * w;
      std::fill(x + pack.used, x + w, x[0]);
    }
  }

  // Predictions for every pack, with the relative error `off`.
  void predict(double off) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> either_way(-off, off);
    predictions = state[0];
    for (const Pack* pack : packs) {
      double* x = predictions.data() + pack->unknowns;
      for (std::size_t i = 0; i < size(*pack); ++i) x[i] += std::max(std::abs(x[i]), 1.0) * either_way(random);
      repeat_lane_0(*pack, predictions.data());
    }
  }

  // Unknowns of all lanes.
  [[nodiscard]] std::size_t size(const Pack& pack) const {
    const GroupSolver& s = *layout.solvers[idx(pack.group_class)];
    return idx(s.group_class().n) * static_cast<std::size_t>(s.lanes());
  }

  bool takes_one_iteration() {
    const Counters before = counters;
    if (!run_all()) return false;
    return counters.newton_iterations - before.newton_iterations == counters.group_solutions - before.group_solutions;
  }

  // Solves every pack once.
  bool run_all() { return run(together ? 1 : static_cast<int>(packs.size())); }

  bool run(int calls) {
    double* const q[3] = {at(0), at(1), at(2)};
    bool ok = true;
    for (int i = 0; i < calls; ++i) {
      if (together) {
        std::copy(predictions.begin() + static_cast<std::ptrdiff_t>(layout.first_unknown), predictions.end(),
                  q[0] + layout.first_unknown);
        ok = together->solve(q, Attempt{}, counters, errors) && ok;
        continue;
      }
      Pack& pack = *packs[next];
      std::copy_n(predictions.data() + pack.unknowns, size(pack), q[0] + pack.unknowns);
      ok = solver.solve(pack, q, Attempt{}, counters, errors).ok() && ok;
      if (++next == packs.size()) next = 0;
    }
    return ok;
  }

  const Prepared prepared;
  Layout layout;
  GroupSolver& solver;
  std::vector<double> state[3];
  std::vector<Pack*> packs;            // of the layout; only those of the class, except with +together
  std::unique_ptr<Together> together;  // null without +together
  int lanes = 1;
  std::size_t of_class = 0;         // packs of the class
  std::vector<double> predictions;  // a state
  std::size_t next = 0;
  Counters counters;
  StepErrors errors;
};

PackStep::PackStep(const Prepared& prepared, std::int32_t group_class)
    : impl_(std::make_unique<Impl>(prepared, group_class)) {}
PackStep::~PackStep() = default;

void PackStep::get_ready(int) {
  if (impl_->predictions.size() <= kWorthWarming) (void)impl_->run_all();
}
bool PackStep::run(int calls) { return impl_->run(calls); }
int PackStep::lanes() const { return impl_->lanes; }
std::size_t PackStep::packs() const { return impl_->of_class; }
const Counters& PackStep::counters() const { return impl_->counters; }
ErrorFigures PackStep::error() const {
  ErrorFigures figures;
  impl_->errors.add_to(figures);
  return figures;
}

// ---- pack, in a crowd

Crowd::Crowd(int threads, const std::vector<int>& cores, const std::function<std::unique_ptr<PackStep>()>& make)
    : pin_to_(static_cast<int>(cores.size()) < threads ? std::vector<int>{} : cores), team_(threads, pin_to_) {
  for (int rank = 0; rank < threads; ++rank) steps_.push_back(make());
  ok_.resize(steps_.size());
}

void Crowd::get_ready(int calls) {
  repeat_for(pin_to_.empty() ? kUntilSpread : kUntilAwake, [this] { (void)run(1); });
  team_.run([&](int rank) { steps_[static_cast<std::size_t>(rank)]->get_ready(calls); });
}

bool Crowd::run(int calls) {
  team_.run([&](int rank) {
    const auto r = static_cast<std::size_t>(rank);
    ok_[r] = steps_[r]->run(calls) ? 1 : 0;
  });
  return std::all_of(ok_.begin(), ok_.end(), [](std::uint8_t ok) { return ok != 0; });
}

// ---- step

StepWorkload::StepWorkload(const Prepared& prepared, const std::vector<int>& cores, int iterations)
    : pin_to_(prepared.plan().run.threads > 1 && idx(prepared.plan().run.threads) <= cores.size() ? cores
                                                                                                  : std::vector<int>{}),
      simulator_(prepared, {.iterations = iterations, .pin_to = pin_to_}),
      grid_(prepared.scene()->time()) {
  for (std::int64_t k = 0; k < std::min(kStepsBeforeSteady, grid_.steps()); ++k) {
    if (!advance()) throw Error(Error::Kind::numerical, "the first steps of the motion fail");
  }
}

bool StepWorkload::advance() { return simulator_.step(grid_.time(next_++)).arrived(); }

void StepWorkload::get_ready(int calls) {
  if (simulator_.prepared().plan().run.threads > 1) {
    repeat_for(pin_to_.empty() ? kUntilSpread : kUntilAwake, [this] { (void)run(4); });
  } else {
    (void)advance();
  }
  if (next_ + calls > grid_.steps()) {
    simulator_.reset();
    next_ = 1;
  }
}

bool StepWorkload::run(int calls) {
  std::optional<Pinned> here;  // pins the calling thread, like a run
  if (!pin_to_.empty()) here.emplace(pin_to_[0]);
  bool ok = true;
  for (int i = 0; i < calls; ++i) {
    if (next_ > grid_.steps()) {
      simulator_.reset();
      next_ = 1;
    }
    ok = advance() && ok;
  }
  return ok;
}

}  // namespace assur::measure
