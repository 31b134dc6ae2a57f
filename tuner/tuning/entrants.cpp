#include "tuning/entrants.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "assur/machine.hpp"
#include "assur/plan.hpp"
#include "dispatch/counts.hpp"
#include "dispatch/dispatcher.hpp"
#include "dispatch/together_rules.hpp"
#include "measure/linear.hpp"
#include "measure/meeting.hpp"
#include "measure/motion.hpp"
#include "numbers.hpp"
#include "plan/preparation.hpp"

namespace assur::tuning {
namespace {

constexpr double kNotMeasured = kNan;
constexpr int kDifferent = 16;  // different matrices of one pattern; further lanes repeat them

[[noreturn]] void refuse(const std::string& why) { throw Error(Error::Kind::numerical, why); }

// The class that a cell measures.
std::int32_t class_of(const Cell& cell, const GroupedSystem& structure) {
  if (cell.group_class >= 0) return cell.group_class;
  const std::vector<ClassSize> sizes = class_sizes(structure);
  std::size_t best = 0;
  for (std::size_t k = 1; k < sizes.size(); ++k) {
    const std::pair here(sizes[k].groups, structure.classes[k].n), there(sizes[best].groups, structure.classes[best].n);
    if (here > there) best = k;
  }
  if (sizes.empty()) throw Error(Error::Kind::input, to_string(cell) + ": nothing in it moves");
  return static_cast<std::int32_t>(best);
}

// ---- factor, solve, evaluate

class MatrixGround final : public Ground {
 public:
  MatrixGround(const Cell& cell, const Field& field) : field_(field) {
    if (cell.scene) {
      StructureOptions options;
      options.formulation = cell.formulation;
      structure_ = std::make_shared<const GroupedSystem>(group_equations(cell.scene(), options));
      class_ = class_of(cell, *structure_);
      matrices_ = measure::jacobians(*structure_, class_, kDifferent);
      shape_ = shape_of(structure_->classes[static_cast<std::size_t>(class_)]);
      for (int w = 1; w <= kMostLanes; w *= 2) {
        Strategy s;
        s.solver.backend = "lanes";
        s.solver.lanes = w;
        candidates_.push_back({Kernel::evaluate, s});
      }
    } else {
      matrices_ = measure::random_matrices(cell.n, cell.per_row, kDifferent / 4);
      shape_ = shape_of(matrices_.pattern);
    }
    for (Strategy& s : linear_solvers(field, shape_, kMostLanes)) {
      candidates_.push_back({Kernel::factor, std::move(s)});
    }
  }

  std::vector<Entrant> enter(const Candidate& c) override {
    if (c.kernel == Kernel::evaluate) {
      std::shared_ptr<measure::Workload> work = measure::evaluation(structure_, class_, c.strategy.solver.lanes);
      return {{c.kernel, shape_, c.strategy, work.get(), work, kNotMeasured, kNotMeasured}};
    }
    const auto linear =
        std::make_shared<measure::Linear>(matrices_, c.strategy, find_backend(field_.table, c.strategy.solver.backend));
    if (!linear->refused().empty()) refuse(linear->refused());
    const double backward = linear->backward_error(), forward = linear->forward_error();
    return {{Kernel::factor, shape_, c.strategy, &linear->factor(), linear, backward, forward},
            {Kernel::solve, shape_, c.strategy, &linear->solve(), linear, backward, forward}};
  }

 private:
  const Field& field_;
  measure::Matrices matrices_;
  std::shared_ptr<const GroupedSystem> structure_;
  std::int32_t class_ = 0;
};

// ---- pack

class PacksGround final : public Ground {
 public:
  PacksGround(const Cell& cell, const Field& field)
      : prepared_(prepare(cell.scene(),
                          {.strategy = std::string(name(cell.formulation)) + "/lanes:8", .budget = ThreadBudget{1}})) {
    class_ = class_of(cell, *preparation(prepared_).structure);
    const auto k = static_cast<std::size_t>(class_);
    shape_ = class_shapes(*preparation(prepared_).structure)[k];
    if (cell.kind == Cell::Kind::together) {
      for (Strategy& s : together_strategies(field, cell.formulation, shape_.groups)) {
        candidates_.push_back({Kernel::pack, std::move(s)});
      }
      return;
    }
    Shape level = shape_;
    level.groups = cell.groups;
    for (Strategy& s : pack_strategies(field, cell.formulation, level, cell.policies)) {
      if (cell.kind == Cell::Kind::packs) {
        candidates_.push_back({Kernel::pack, std::move(s)});
        continue;
      }
      // The slowdown by other threads depends on the memory traffic more than on the solver.
      const bool fills = find_backend(field.table, s.solver.backend).fills_lanes;
      if (!(fills ? s.solver.lanes == 1 || s.solver.lanes == 8 : s.solver == SolverSettings{})) continue;
      // One thread takes part in the same race: a second later the machine may be twice as fast.
      for (s.run.threads = 1; s.run.threads <= field.budget.threads; s.run.threads *= 2)
        candidates_.push_back({Kernel::pack, s});
    }
  }

  // The plan of the other classes is unchanged: they are solved once, for the inputs of this class.
  std::vector<Entrant> enter(const Candidate& c) override {
    if (c.strategy.run.threads > 1) {
      const auto crowd =
          std::make_shared<measure::Crowd>(c.strategy.run.threads, this_machine().cores, [&] { return pack_step(c); });
      return {{Kernel::pack, shape_, c.strategy, crowd.get(), crowd, kNotMeasured, kNotMeasured}};
    }
    const std::shared_ptr<measure::PackStep> packs = pack_step(c);
    Entrant out{Kernel::pack, shape_, c.strategy, packs.get(), packs, packs->error().residual(), kNotMeasured};
    if (c.strategy.run.together) out.packs_of_call = static_cast<int>(packs->packs());
    return {std::move(out)};
  }

 private:
  [[nodiscard]] std::unique_ptr<measure::PackStep> pack_step(const Candidate& c) const {
    Preparation changed = preparation(prepared_);
    changed.plan.run.together = c.strategy.run.together;
    changed.plan.choices[static_cast<std::size_t>(class_)].solver = c.strategy.solver;
    return std::make_unique<measure::PackStep>(Preparation::shared(std::move(changed)), class_);
  }

  Prepared prepared_;
  std::int32_t class_ = 0;
};

// ---- step

class StepsGround final : public Ground {
 public:
  StepsGround(const Cell& cell, const Field& field) : scene_(cell.scene()), budget_(field.budget) {
    StructureOptions options;
    options.formulation = cell.formulation;
    const GroupedSystem structure = group_equations(scene_, options);
    const std::vector<Shape> shapes = class_shapes(structure);
    shape_ = shape_of_step(structure, shapes);
    // Candidates fill the lanes with the class that has most operations in all its groups.
    const std::vector<ClassSize> sizes = class_sizes(structure);
    Shape all, level;
    for (std::size_t k = 0; k < shapes.size(); ++k) {
      const Shape& s = shapes[k];
      if (s.groups * (s.operations + s.terms) <= all.groups * (all.operations + all.terms)) continue;
      all = level = s;
      level.groups = sizes[k].side_by_side;
    }
    if (shape_.n == 0) throw Error(Error::Kind::input, to_string(cell) + ": nothing in it moves");
    if (!cell.only.empty()) {
      for (const Strategy& s : cell.only) candidates_.push_back({Kernel::step, s});
      return;
    }
    if (cell.kind == Cell::Kind::around) {
      const AroundCounts around = around_counts(structure);
      around_ = {.n = static_cast<std::int32_t>(around.unknowns), .terms = around.pieces};
    }
    if (!around_ && structure.levels > 1 && why_not_together(structure).empty()) {
      for (Strategy& s : together_strategies(field, cell.formulation, all.groups)) {
        candidates_.push_back({Kernel::step, std::move(s)});
      }
    }
    for (Strategy& s : pack_strategies(field, cell.formulation, level, true)) {
      if (cell.kind == Cell::Kind::around) {
        if (measures_around(s, level)) candidates_.push_back({Kernel::step, s});
        continue;
      }
      candidates_.push_back({Kernel::step, s});
      if (s.solver.once || level.groups == 1) continue;
      for (int p = 2; p <= std::min(field.budget.threads, level.groups); p *= 2) {
        s.run.threads = p;
        if (field.why_not(s).empty()) candidates_.push_back({Kernel::step, s});
      }
    }
  }

  std::vector<Entrant> enter(const Candidate& c) override {
    PrepareOptions options;
    options.strategy = to_string(c.strategy);
    options.budget = budget_;
    const Prepared prepared = prepare(scene_, options);
    const auto step = std::make_shared<measure::StepWorkload>(prepared, this_machine().cores);
    std::vector<Entrant> out = {
        {Kernel::step, shape_, c.strategy, step.get(), step, step->report().error.residual(), kNotMeasured}};
    if (!around_) return out;
    const std::vector<Shape> shapes = class_shapes(*preparation(prepared).structure);
    for (std::size_t k = 0; k < shapes.size(); ++k) {
      const auto pack = std::make_shared<measure::PackStep>(prepared, static_cast<std::int32_t>(k));
      // A class with few groups on a level takes fewer lanes than the strategy says.
      Strategy own = c.strategy;
      own.solver.lanes = pack->lanes();
      Entrant part{Kernel::pack, shapes[k], own, pack.get(), pack, pack->error().residual(), kNotMeasured};
      part.packs_of_step = static_cast<int>(pack->packs());
      out.push_back(std::move(part));
    }
    return out;
  }

 private:
  // The time of a step beyond its packs does not depend on the solver, but a little on the number of packs. It is
  // measured with the two widest strategies of the fastest backend, which plans mostly use.
  [[nodiscard]] static bool measures_around(const Strategy& s, const Shape& level) {
    return s.solver.backend == "lanes" && !s.solver.once && 4 * s.solver.lanes > std::min(level.groups, kMostLanes);
  }

  Scene scene_;
  ThreadBudget budget_;
};

// ---- meeting

class MeetingGround final : public Ground {
 public:
  MeetingGround(const Cell& cell, const Field& field) {
    shape_.n = cell.n;
    for (int p = 2; p <= field.budget.threads; ++p) {
      Strategy s;
      s.run.formulation = Formulation::irreducible;
      s.solver.backend = "lanes";
      s.run.threads = p;
      candidates_.push_back({Kernel::meeting, s});
    }
  }

  std::vector<Entrant> enter(const Candidate& c) override {
    const auto meeting = std::make_shared<measure::Meeting>(c.strategy.run.threads, shape_.n);
    return {{Kernel::meeting, shape_, c.strategy, meeting.get(), meeting, kNotMeasured, kNotMeasured}};
  }
};

}  // namespace

std::unique_ptr<Ground> open(const Cell& cell, const Field& field) {
  switch (cell.kind) {
    case Cell::Kind::matrix:
      return std::make_unique<MatrixGround>(cell, field);
    case Cell::Kind::packs:
    case Cell::Kind::together:
    case Cell::Kind::crowd:
      return std::make_unique<PacksGround>(cell, field);
    case Cell::Kind::steps:
    case Cell::Kind::around:
      return std::make_unique<StepsGround>(cell, field);
    case Cell::Kind::meeting:
      return std::make_unique<MeetingGround>(cell, field);
  }
  return nullptr;
}

}  // namespace assur::tuning
