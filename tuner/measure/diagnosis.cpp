#include "measure/diagnosis.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "equations/evaluator.hpp"

namespace assur::measure {
namespace {

constexpr std::int32_t kMostInverted = 200;  // unknowns: some milliseconds a group

std::size_t idx(std::int32_t i) { return static_cast<std::size_t>(i); }

std::vector<double> gather(const std::vector<std::int32_t>& places, const std::vector<double>& from) {
  std::vector<double> out;
  for (const std::int32_t place : places) out.push_back(from[idx(place)]);
  return out;
}

double largest(const std::vector<double>& values) {
  double most = 0;
  for (const double v : values) most = std::max(most, std::abs(v));
  return most;
}

}  // namespace

// Equations and inverse of one class.
struct Diagnosis::Probe {
  Probe(const Structure& structure, std::int32_t group_class)
      : program(compile(structure.classes[idx(group_class)], structure.pattern(group_class))),
        evaluator(make_evaluator(*structure.system, program, 1)),
        coefficients(program.coefficients.size()),
        phi(idx(program.n)),
        scale(phi.size()),
        jacobian(program.pattern.row.size()) {
    // Behind the coefficients of the program stand the numbers 0 and 1.
    coefficients.push_back(0);
    coefficients.push_back(1);
    if (program.n > kMostInverted || program.n == 0) return;
    solver = find_backend(core_backends(), "eigen").make({}, Precision::binary64);
    if (!solver->analyze(program.pattern, 1).ok()) solver.reset();
  }

  GroupFigures look(const Structure& structure, const Group& group, const std::vector<double>& posture) {
    const std::vector<double> inputs = gather(group.inputs, posture), unknowns = gather(group.unknowns, posture);
    bind_coefficients(program, gather(group.constants, structure.system->constants), coefficients.data(), 1);
    evaluator->set_inputs(coefficients.data(), inputs.data());
    evaluator->evaluate(unknowns.data(), phi.data(), jacobian.data());
    evaluator->scale(scale.data());
    GroupFigures figures;
    for (std::size_t i = 0; i < phi.size(); ++i) {
      const double r = scale[i] > 0 ? std::abs(phi[i]) / scale[i] : std::abs(phi[i]);
      if (!(r <= figures.residual)) figures.residual = r;
    }
    if (solver) figures.condition = condition(unknowns);
    return figures;
  }

  // A scale for each equation on the right: then the rows of |x| add up to what all of them can do together.
  double condition(const std::vector<double>& unknowns) {
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    if (!solver->factorize(jacobian).ok()) return kInfinite;
    const std::size_t n = phi.size();
    std::vector<double> columns(n * n, 0.0), rows(n, 0.0);
    for (std::size_t j = 0; j < n; ++j) columns[j * n + j] = scale[j];
    if (!solver->solve(columns, program.n).ok()) return kInfinite;
    for (std::size_t k = 0; k < columns.size(); ++k) rows[k % n] += std::abs(columns[k]);
    return largest(rows) / std::max(largest(unknowns), std::numeric_limits<double>::min());
  }

  Program program;
  std::unique_ptr<Evaluator> evaluator;
  std::vector<double> coefficients, phi, scale, jacobian;
  std::unique_ptr<LinearSolver> solver;  // null: the group is too large
};

Diagnosis::Diagnosis(const Prepared& prepared, bool with_reference) {
  if (with_reference) truth_ = std::make_unique<TruePosture>(prepared);
  prepare_probes(prepared.structure);
}

Diagnosis::~Diagnosis() = default;

void Diagnosis::prepare_probes(const std::shared_ptr<const Structure>& structure) {
  structure_ = structure;
  probes_.clear();
  for (std::size_t c = 0; c < structure->classes.size(); ++c) {
    probes_.push_back(std::make_unique<Probe>(*structure, static_cast<std::int32_t>(c)));
  }
}

std::vector<GroupFigures> Diagnosis::look(const Simulator& simulator) {
  // A simulator that has chosen anew among redundant equations has another structure.
  if (simulator.prepared().structure != structure_) prepare_probes(simulator.prepared().structure);
  const std::vector<double> posture = posture_of(simulator);
  const std::int64_t counted = simulator.report().counters.newton_iterations,
                     before = std::exchange(iterations_, counted);
  std::vector<GroupFigures> all;
  for (const Group& group : structure_->groups) {
    GroupFigures figures = probes_[idx(group.group_class)]->look(*structure_, group, posture);
    if (structure_->groups.size() == 1) figures.iterations = counted - before;
    if (truth_) figures.error = truth_->error(simulator.time(), posture, group.unknowns);
    all.push_back(std::move(figures));
  }
  return all;
}

}  // namespace assur::measure
