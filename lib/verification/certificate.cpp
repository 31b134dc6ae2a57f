#include "verification/certificate.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "decimal.hpp"
#include "equations/drive.hpp"
#include "equations/lowering.hpp"
#include "equations/outputs.hpp"
#include "graph/block_names.hpp"
#include "graph/demand.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "plan/preparation.hpp"
#include "simulation/simulator_access.hpp"

namespace assur {

namespace {

constexpr std::size_t kDenseProof = 400;  // unknowns: inverses and products are dense, n^3 each

std::string figure(double x) { return scientific(x, 1); }

// The reason why the proof failed.
std::string why_not(const SolutionProof& p) {
  if (!std::isfinite(p.defect)) return "its Jacobian is singular";
  if (!(p.defect < 1)) {
    return "it is too close to singular: |I - C J| = " + figure(p.defect) + ", where less than 1 is needed";
  }
  return "it is too close to singular for the error of its posture: 4 B Y / (1 - Z1)^2 = " +
         figure(4 * p.curvature * p.correction / ((1 - p.defect) * (1 - p.defect))) + ", where less than 1 is needed";
}

// For a row that differs from the output of this plan.
Certificate not_this_motion(double t, bool in_chunks) {
  return {t, kInfinity, 0, "",
          in_chunks ? "the trajectory was computed in chunks, whose postures are not kept; compute it without +chunks"
                    : "the plan with these settings computes other outputs than the trajectory"};
}

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

const Scene& scene_of(const Preparation& prepared) {
  if (prepared.scene) return *prepared.scene;
  throw Error(Error::Kind::input, "a loaded plan has no scene, which a certificate needs: prepare the scene instead");
}

}  // namespace

Certifier::Certifier(const Preparation& prepared)
    : structure_(prepared.structure),
      controlled_(prepared.controlled),
      system_(lower(std::make_shared<const Scene>(scene_of(prepared)), controlled_,
                    structure_->formulation != Formulation::irreducible)),
      at_(system_.coordinates.size()),
      middle_(at_.size()),
      column_(at_.size(), -1) {
  find_blocks(*structure_);
}

// Finds the blocks of the solved equations that the outputs need.
void Certifier::find_blocks(const GroupedSystem& structure) {
  std::vector<Index> equations, unknowns;
  for (std::size_t c = 0; c < system_.coordinates.size(); ++c) {
    if (system_.coordinates[c].role == Role::unknown) unknowns.push_back(static_cast<Index>(c));
  }
  for (std::size_t e = 0; e < system_.equations.size(); ++e) {
    const auto& watched = structure.checks;
    if (std::find(watched.begin(), watched.end(), static_cast<Index>(e)) == watched.end()) {
      equations.push_back(static_cast<Index>(e));
    }
  }
  blocks_ = decompose(system_, equations, unknowns);
  std::vector<std::int8_t> need = needed_by_outputs(system_, wanted_outputs(system_));
  const std::vector<std::uint8_t> needed = needed_blocks(system_, blocks_, need);
  for (Index b = 0; b < blocks_.size(); ++b) {
    if (needed[idx(b)] != 0) needed_.push_back(b);
  }
  std::vector<std::uint8_t> read(need.size());
  std::transform(need.begin(), need.end(), read.begin(), [](std::int8_t n) { return n >= 0 ? 1 : 0; });
  driven_ = driven_behind(system_, std::move(read));
}

Certificate Certifier::certify(std::span<const double> posture, double t) {
  Certificate out;
  out.time = t;
  out.uniqueness = kInfinity;
  std::fill(at_.begin(), at_.end(), Ball<double>(0, kInfinity));
  at_[idx(kOne)] = 1;
  middle_[idx(kOne)] = 1;
  drive(t);
  take_unknowns(posture);
  Index worst = -1;
  for (const Index b : needed_) {
    const SolutionProof proof = enclose(b, out.why_not);
    out.uniqueness = std::min(out.uniqueness, proof.uniqueness);
    const double radius = proof.holds ? proof.radius.maxCoeff() : kInfinity;
    if (radius <= out.radius) continue;
    out.radius = radius;
    worst = b;
  }
  if (worst >= 0) out.group = group_or_block_name(system_, blocks_, worst);
  return out;
}

void Certifier::drive(double t) {
  const auto jet = [&](std::size_t input, int k) -> Jet<Ball<Quad>> {
    const DriverInput& in = system_.inputs[input];
    const Law& law = in.laws[static_cast<std::size_t>(k)];
    const std::string& name = system_.drivers[idx(in.driver)];
    const bool known = std::find(controlled_.begin(), controlled_.end(), name) == controlled_.end();
    if (known && law.covers(t)) return evaluate<Ball<Quad>>(law, Ball<Quad>(t));
    const Ball<Quad> anything(0, kInfinity);
    return {anything, anything, anything};
  };
  assur::drive<Ball<Quad>>(system_, driven_, jet, middle_.data(), nullptr, nullptr);
  const auto round = [&](Index c) {
    Ball<Quad>& exact = middle_[idx(c)];
    const auto rounded = static_cast<double>(exact);
    at_[idx(c)] = {rounded, (exact - Ball<Quad>(rounded)).magnitude()};
    exact = rounded;
  };
  for (const Index i : driven_.inputs) {
    const DriverInput& in = system_.inputs[idx(i)];
    for (Index c = in.first; c < in.first + in.count; ++c) round(c);
  }
  for (const Index a : driven_.assignments) round(system_.assignments[idx(a)].coordinate);
}

// Coordinates that presolve eliminated follow from the others.
void Certifier::take_unknowns(std::span<const double> posture) {
  const System& solved = *structure_->system;
  for (const Index b : needed_) {
    for (const Index u : blocks_.unknowns_of(b)) {
      const Coordinate& c = system_.coordinates[idx(u)];
      const Index form = solved.items[idx(c.item)].form[std::max<int>(c.component, 0)];
      at_[idx(u)] = form_value<double>(solved, form, posture);
      middle_[idx(u)] = at_[idx(u)].middle();
    }
  }
}

SolutionProof Certifier::enclose(Index b, std::string& first_reason) {
  SolutionProof proof;
  std::string why = why_out_of_reach(b);
  if (why.empty()) {
    number_columns(b);
    proof = prove_solution(equations_of(b));
    for (const Index c : read_) column_[idx(c)] = -1;
    if (!proof.holds) why = why_not(proof);
  }
  if (first_reason.empty()) first_reason = std::move(why);
  Eigen::Index i = 0;
  for (const Index u : blocks_.unknowns_of(b)) {
    at_[idx(u)] = {at_[idx(u)].middle(), proof.holds ? proof.radius[i] : kInfinity};
    ++i;
  }
  return proof;
}

// Reasons that do not depend on the posture's numbers.
std::string Certifier::why_out_of_reach(Index b) const {
  const auto equations = blocks_.equations_of(b), unknowns = blocks_.unknowns_of(b);
  for (const Index e : equations) {
    if (system_.equations[idx(e)].callback >= 0) {
      return "its equations are not quadratic (quadratic: false): " + system_.equation_name(e) +
             " is computed by a function of the program";
    }
  }
  std::vector<Index> mentioned;
  for (const Index e : equations) {
    system_.mentioned(e, mentioned);
    for (const Index c : mentioned) {
      if (std::isfinite(at_[idx(c)].radius())) continue;
      if (system_.coordinates[idx(c)].role == Role::unknown) return "it depends on a group without a proof";
      return "it depends on a driver that has no law at this time: " + system_.coordinate_name(c);
    }
  }
  if (unknowns.size() <= kDenseProof) return "";
  return "it has " + std::to_string(unknowns.size()) + " unknowns: the proof is dense, and limited to " +
         std::to_string(kDenseProof);
}

// Columns of the block's matrices: its unknowns, then the other coordinates that its equations read.
void Certifier::number_columns(Index b) {
  std::vector<Index> mentioned;
  read_.clear();
  for (const Index u : blocks_.unknowns_of(b)) {
    column_[idx(u)] = static_cast<Index>(read_.size());
    read_.push_back(u);
  }
  for (const Index e : blocks_.equations_of(b)) {
    system_.mentioned(e, mentioned);
    for (const Index c : mentioned) {
      if (column_[idx(c)] >= 0) continue;
      column_[idx(c)] = static_cast<Index>(read_.size());
      read_.push_back(c);
    }
  }
}

ProofEquations Certifier::equations_of(Index b) const {
  const auto equations = blocks_.equations_of(b);
  const auto n = static_cast<Eigen::Index>(equations.size()), m = static_cast<Eigen::Index>(read_.size()) - n;
  BallMatrix residual{Eigen::MatrixXd(n, 1), Eigen::MatrixXd(n, 1)};
  Eigen::MatrixXd middle(n, n + m), radius(n, n + m);
  std::vector<Ball<double>> row(read_.size());
  for (Eigen::Index i = 0; i < n; ++i) {
    const Index e = equations[static_cast<std::size_t>(i)];
    const Ball<Quad> phi = assur::residual<Ball<Quad>>(system_, e, middle_);
    residual.middle(i) = static_cast<double>(phi);
    residual.radius(i) = (phi - Ball<Quad>(residual.middle(i))).magnitude();
    std::fill(row.begin(), row.end(), Ball<double>(0));
    gradient<Ball<double>>(system_, e, at_, [&](Index c, const Ball<double>& value) {
      if (column_[idx(c)] >= 0) row[idx(column_[idx(c)])] += value;
    });
    for (Eigen::Index j = 0; j < n + m; ++j) {
      middle(i, j) = row[static_cast<std::size_t>(j)].middle();
      radius(i, j) = row[static_cast<std::size_t>(j)].radius();
    }
  }
  Eigen::VectorXd box(m);
  for (Eigen::Index j = 0; j < m; ++j) box[j] = at_[idx(read_[static_cast<std::size_t>(n + j)])].radius();
  return {std::move(residual),
          {middle.leftCols(n), radius.leftCols(n)},
          {middle.rightCols(m), radius.rightCols(m)},
          std::move(box),
          [this, b](const Eigen::VectorXd& d) { return curvature(b, d); }};
}

// A bound: a product c a(q) b(q) of forms has curvature c (a(d) b(e) + a(e) b(d)) / 2.
Eigen::VectorXd Certifier::curvature(Index b, const Eigen::VectorXd& d) const {
  const auto n = static_cast<Index>(d.size());
  const auto magnitude = [&](Index constant) { return std::abs(system_.constants[idx(constant)]); };
  const auto change = [&](Index form) {
    double sum = 0;
    for (const Term& t : system_.form(form)) {
      const Index j = column_[idx(t.coordinate)];
      if (j >= 0 && j < n) sum = up(sum + up(magnitude(t.constant) * d[j]));
    }
    return sum;
  };
  Eigen::VectorXd out = Eigen::VectorXd::Zero(d.size());
  for (Index i = 0; i < n; ++i) {
    for (const Product& p : system_.products_of(system_.equations[idx(blocks_.equations_of(b)[idx(i)])])) {
      out[i] = up(out[i] + up(magnitude(p.constant) * up(change(p.a) * change(p.b))));
    }
  }
  return out;
}

Certificate certify(const Simulator& simulator) {
  return Certifier(preparation(simulator.prepared())).certify(SimulatorAccess::posture(simulator), simulator.time());
}

std::vector<Certificate> certify(const Prepared& prepared, const Trajectory& trajectory, StepSettings settings) {
  std::vector<Certificate> out;
  Preparation plan = preparation(prepared);
  const bool in_chunks = std::exchange(plan.plan.run.chunks, 1) > 1;
  Simulator simulator(Preparation::shared(std::move(plan)), std::move(settings));
  std::shared_ptr<const GroupedSystem> structure;
  std::optional<Certifier> certifier;
  (void)simulator.run(trajectory.times(), [&](std::int64_t done, std::int64_t) {
    const std::span<const double> row = trajectory.row(static_cast<std::size_t>(done - 1)), now = simulator.outputs();
    if (!std::equal(row.begin(), row.end(), now.begin(), now.end(), [](double a, double b) { return same(a, b); })) {
      out.push_back(not_this_motion(simulator.time(), in_chunks));
      return false;
    }
    const Prepared now_prepared = simulator.prepared();
    if (structure != preparation(now_prepared).structure) {  // reselection of redundant equations changes the structure
      structure = preparation(now_prepared).structure;
      certifier.emplace(preparation(now_prepared));
    }
    out.push_back(certifier->certify(SimulatorAccess::posture(simulator), simulator.time()));
    return false;
  });
  while (out.size() < trajectory.rows()) out.push_back(not_this_motion(trajectory.times()[out.size()], in_chunks));
  return out;
}

}  // namespace assur
