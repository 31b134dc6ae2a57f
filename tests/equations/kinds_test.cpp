// Every kind of constraint, driver and body, as equations of the system and as a program over lanes.
#include "equations/kinds.hpp"

#include <gtest/gtest.h>

#include <random>

#include "assur/plan.hpp"
#include "assur/simulator.hpp"
#include "decompositions.hpp"
#include "equations/drive.hpp"
#include "equations/lowering.hpp"
#include "equations/residual_scale.hpp"
#include "evaluation/evaluator.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "structure/look.hpp"

namespace assur {
namespace {

using kinds::Kind;
using references::Posture;
using references::Quad;
using references::QuadJet;
using enum Formulation;

class EveryKind : public testing::TestWithParam<Kind> {
 protected:
  const Kind& kind() const { return GetParam(); }
  System system(bool declared_groups = true) const {
    return lower(std::make_shared<const Scene>(kind().scene), {}, declared_groups);
  }
};

// All coordinates on the path in internal units: hidden inputs come from the laws, all others from the closed form.
std::vector<QuadJet> on_path(const System& s, const Kind& kind, double t) {
  const std::size_t n = s.coordinates.size();
  std::vector<double> q(n, 0), rate(n, 0), acceleration(n, 0);
  EXPECT_TRUE(drive(s, t, q.data(), rate.data(), acceleration.data()).ok());
  const Posture<QuadJet> path = kind.path(t);
  std::vector<QuadJet> out(n);
  out[kOne] = QuadJet{1};
  for (std::size_t c = 1; c < n; ++c) {
    const Coordinate& coordinate = s.coordinates[c];
    const Item& item = s.items[idx(coordinate.item)];
    if (item.hidden) {
      out[c] = {q[c], rate[c], acceleration[c]};
    } else {
      const auto k = static_cast<std::size_t>(std::max<int>(coordinate.component, 0));
      out[c] = path.at(item.name)[k] * Quad(1 / s.unit(coordinate.dimension));
    }
  }
  return out;
}
std::vector<Quad> values(const std::vector<QuadJet>& x) {
  std::vector<Quad> out;
  for (const QuadJet& j : x) out.push_back(j.value);
  return out;
}
std::vector<double> doubles(const std::vector<Quad>& x) {
  std::vector<double> out;
  for (const Quad& v : x) out.push_back(static_cast<double>(v));
  return out;
}
double magnitude(const Quad& x) { return std::abs(static_cast<double>(x)); }

// ---- as equations

// Laws and lengths are rounded to double and all else is in quad, so errors are a few units in the last place of the
// terms.
TEST_P(EveryKind, EquationsHoldOnAKnownMotion) {
  for (const bool declared : {true, false}) {
    const System s = system(declared);
    for (const double t : {0.0, 0.25, 0.625, 1.0}) {
      const std::vector<Quad> q = values(on_path(s, kind(), t));
      for (Index e = 0; e < static_cast<Index>(s.equations.size()); ++e) {
        const double scale = std::max(residual_scale(s, e, doubles(q)), 1e-3);
        EXPECT_LE(magnitude(residual<Quad>(s, e, q)), 16 * kEps * scale) << s.equation_name(e) << " at " << t;
      }
    }
  }
}

// There are as many equations as unknowns, and the equations are regular. The path is therefore their only solution.
TEST_P(EveryKind, EquationsDetermineTheMotion) {
  for (const bool declared : {true, false}) {
    const System s = system(declared);
    std::vector<Index> rows, unknowns, mentioned;
    for (std::size_t c = 0; c < s.coordinates.size(); ++c) {
      if (s.coordinates[c].role == Role::unknown) unknowns.push_back(static_cast<Index>(c));
    }
    for (Index e = 0; e < static_cast<Index>(s.equations.size()); ++e) {
      s.mentioned(e, mentioned);
      if (std::any_of(mentioned.begin(), mentioned.end(),
                      [&](Index c) { return s.coordinates[idx(c)].role == Role::unknown; })) {
        rows.push_back(e);
      }
    }
    ASSERT_EQ(rows.size(), unknowns.size());
    if (rows.empty()) continue;
    for (const double t : {0.0, 0.5, 1.0}) {
      const std::vector<double> q = doubles(values(on_path(s, kind(), t)));
      std::vector<Index> column(s.coordinates.size(), -1);
      for (std::size_t j = 0; j < unknowns.size(); ++j) column[idx(unknowns[j])] = static_cast<Index>(j);
      Eigen::MatrixXd j =
          Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(rows.size()));
      for (std::size_t i = 0; i < rows.size(); ++i) {
        gradient<double>(s, rows[i], q, [&](Index c, double g) {
          if (column[idx(c)] >= 0) j(static_cast<Eigen::Index>(i), column[idx(c)]) += g;
        });
      }
      const Eigen::VectorXd sigma = j.jacobiSvd().singularValues();
      EXPECT_GE(sigma[sigma.size() - 1] / sigma[0], 1e-4) << t;
    }
  }
}

TEST_P(EveryKind, DrivenCoordinatesFollowTheLaw) {
  const System s = system();
  for (const double t : {0.0, 0.375, 1.0}) {
    const std::vector<QuadJet> expected = on_path(s, kind(), t);
    const std::size_t n = s.coordinates.size();
    std::vector<double> q(n, 0), rate(n, 0), acceleration(n, 0);
    q[kOne] = 1;
    ASSERT_TRUE(drive(s, t, q.data(), rate.data(), acceleration.data()).ok());
    for (const Assignment& a : s.assignments) {
      const std::size_t c = idx(a.coordinate);
      EXPECT_EQ(s.coordinates[c].role, Role::driven);
      const std::string name = s.coordinate_name(a.coordinate);
      // These are sums of a few terms of size 1 to 10.
      EXPECT_LE(magnitude(expected[c].value - q[c]), 32 * kEps) << name;
      EXPECT_LE(magnitude(expected[c].rate - rate[c]), 64 * kEps) << name;
      EXPECT_LE(magnitude(expected[c].acceleration - acceleration[c]), 128 * kEps) << name;
    }
  }
}

TEST_P(EveryKind, MembersMoveWithTheirBody) {
  const System s = system();
  for (const double t : {0.0, 0.375, 1.0}) {
    const std::vector<Quad> q = values(on_path(s, kind(), t));
    for (const auto& [name, at] : kind().members(t)) {
      const Item& item = s.item(name);
      EXPECT_TRUE(item.derived);
      for (int k = 0; k < item.components; ++k) {
        const Quad here = form_value<Quad>(s, item.form[k], q) * s.unit(item.dimension);
        EXPECT_LE(magnitude(here - at[static_cast<std::size_t>(k)].value), 16 * kEps) << name << " " << k;
      }
    }
  }
}

// Central differences of a quadratic polynomial are exact for every step; a long step keeps rounding small.
TEST_P(EveryKind, GradientIsTheDerivative) {
  const System s = system();
  std::vector<Quad> q = values(on_path(s, kind(), 0.5));
  std::vector<Index> mentioned;
  for (Index e = 0; e < static_cast<Index>(s.equations.size()); ++e) {
    std::map<Index, Quad> g;
    gradient<Quad>(s, e, q, [&](Index c, const Quad& v) { g[c] += v; });
    g.erase(kOne);
    s.mentioned(e, mentioned);
    EXPECT_LE(g.size(), mentioned.size());
    for (const Index c : mentioned) {
      const Quad here = q[idx(c)];
      q[idx(c)] = here + Quad(0.5);
      const Quad up = residual<Quad>(s, e, q);
      q[idx(c)] = here - Quad(0.5);
      const Quad difference = up - residual<Quad>(s, e, q);
      q[idx(c)] = here;
      EXPECT_LE(magnitude(difference - g[c]), 1e-28) << s.equation_name(e) << " " << s.coordinate_name(c);
    }
  }
}

// ---- as a program

// One instance in one lane: a system with its own constants, a posture and a motion.
struct Lane {
  System system, absolute;  // `absolute` has positive constants, to bound sums
  std::vector<double> q, rate, acceleration;
};

std::vector<double> absolute(const std::vector<double>& x) {
  std::vector<double> out;
  for (const double v : x) out.push_back(std::abs(v));
  return out;
}
double sum_of_terms(const Lane& lane, Index equation, const std::vector<double>& q) {
  System s = lane.absolute;
  return std::abs(residual<double>(s, equation, absolute(q)));
}

class Pack {
 public:
  Pack(const GroupedSystem& structure, const SolvedGroup& group, int lanes)
      : structure_(structure),
        group_(group),
        class_(look::class_of(structure, group)),
        evaluator_(make_evaluator(*structure.system, class_, lanes)),
        w_(static_cast<std::size_t>(lanes)),
        coefficients_(class_.coefficients.size() * w_) {
    std::mt19937 random(static_cast<unsigned>(lanes));
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<double> constants(group.constants.size() * w_);
    for (std::size_t l = 0; l < w_; ++l) {
      Lane lane{*structure.system, *structure.system, structure.start, {}, {}};
      for (std::size_t k = idx(kLiterals); k < lane.system.constants.size(); ++k)
        lane.system.constants[k] *= 1 + 0.1 * unit(random);
      for (double& k : lane.absolute.constants) k = 2 * std::abs(k);
      lane.rate.assign(lane.q.size(), 0);
      lane.acceleration.assign(lane.q.size(), 0);
      for (std::size_t c = 1; c < lane.q.size(); ++c) {
        lane.q[c] += 0.25 * unit(random);
        if (!moves(static_cast<Index>(c))) continue;
        lane.rate[c] = unit(random);
        lane.acceleration[c] = unit(random);
      }
      for (std::size_t k = 0; k < group.constants.size(); ++k) {
        constants[k * w_ + l] = lane.system.constants[idx(group.constants[k])];
      }
      lanes_.push_back(std::move(lane));
    }
    bind_coefficients(class_, constants.data(), coefficients_.data(), w_);
  }

  void check() {
    const std::size_t n = idx(class_.n), rows = class_.equations.size();
    std::vector<double> phi(rows * w_), jacobian(idx(class_.pattern.nnz()) * w_), scale(rows * w_), velocity(rows * w_),
        acceleration(rows * w_);
    evaluator_->set_inputs(coefficients_.data(), gather(group_.inputs, &Lane::q).data());
    evaluator_->evaluate(gather(group_.unknowns, &Lane::q).data(), phi.data(), jacobian.data());
    evaluator_->scale(scale.data());
    std::vector<double> raised = scale;
    evaluator_->raise_scale(raised.data());
    evaluator_->velocity_rhs(gather(group_.inputs, &Lane::rate).data(), velocity.data());
    evaluator_->acceleration_rhs(gather(group_.unknowns, &Lane::rate).data(),
                                 gather(group_.inputs, &Lane::acceleration).data(), acceleration.data());
    const std::vector<double> bend = bend_of_motion(velocity, acceleration);
    for (std::size_t l = 0; l < w_; ++l) {
      const Lane& lane = lanes_[l];
      std::vector<double> reach = absolute(lane.q);
      for (std::size_t c = 1; c < reach.size(); ++c)
        reach[c] += std::abs(lane.rate[c]) + std::abs(lane.acceleration[c]);
      Eigen::MatrixXd j = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(n));
      for (std::size_t c = 0; c < n; ++c) {
        for (Index k = class_.pattern.column_start[c]; k < class_.pattern.column_start[c + 1]; ++k) {
          j(class_.pattern.row[idx(k)], static_cast<Eigen::Index>(c)) = jacobian[idx(k) * w_ + l];
        }
      }
      for (std::size_t i = 0; i < rows; ++i) {
        const Index e = group_.equations[i];
        const std::string what = structure_.system->equation_name(e);
        const double at_rest = sum_of_terms(lane, e, lane.q), moving = sum_of_terms(lane, e, reach);
        EXPECT_NEAR(phi[i * w_ + l], residual<double>(lane.system, e, lane.q), 16 * kEps * at_rest) << what;
        const double size = size_of_terms(lane.system, e, lane.q), against = residual_scale(lane.system, e, lane.q);
        EXPECT_NEAR(scale[i * w_ + l], size, 64 * kEps * size) << what;
        EXPECT_NEAR(raised[i * w_ + l], against, 64 * kEps * against) << what;
        check_row(lane, e, j.row(static_cast<Eigen::Index>(i)), moving);
        // Along q + s q' + s^2/2 q'' an equation is a polynomial of degree 4 in s: five points give its derivatives.
        const auto f = [&](int s) { return along(lane, e, s); };
        const Quad first = (8 * (f(1) - f(-1)) - (f(2) - f(-2))) / 12;
        const Quad second = (16 * (f(1) + f(-1)) - (f(2) + f(-2)) - 30 * f(0)) / 12;
        double j_rate = 0, j_acceleration = 0;
        for (std::size_t c = 0; c < n; ++c) {
          j_rate += j(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c)) * lane.rate[idx(group_.unknowns[c])];
          j_acceleration += j(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c)) *
                            lane.acceleration[idx(group_.unknowns[c])];
        }
        EXPECT_NEAR(j_rate - velocity[i * w_ + l], static_cast<double>(first), 64 * kEps * moving) << what;
        EXPECT_NEAR(j_acceleration - acceleration[i * w_ + l], static_cast<double>(second), 64 * kEps * moving) << what;
        const double expected = static_cast<double>((curvature(lane, e, 1) - curvature(lane, e, -1)) / 4);
        EXPECT_NEAR(bend[i * w_ + l], expected, 64 * kEps * moving) << what;
      }
    }
  }

 private:
  // Phi''[q', q'']; velocity and acceleration: right-hand sides, which must stay the same.
  [[nodiscard]] std::vector<double> bend_of_motion(const std::vector<double>& velocity,
                                                   const std::vector<double>& acceleration) {
    std::vector<double> a = gather(group_.unknowns, &Lane::rate), of_inputs = gather(group_.inputs, &Lane::rate);
    std::vector<double> b = gather(group_.unknowns, &Lane::acceleration);
    std::vector<double> b_of_inputs = gather(group_.inputs, &Lane::acceleration);
    std::vector<double> bent(velocity.size()), out(velocity.size()), again(velocity.size());
    evaluator_->subtract_bend({a.data(), of_inputs.data()}, {b.data(), b_of_inputs.data()}, -1, bent.data(),
                              out.data());
    evaluator_->velocity_rhs(gather(group_.inputs, &Lane::rate).data(), again.data());
    EXPECT_EQ(again, velocity);
    evaluator_->acceleration_rhs(gather(group_.unknowns, &Lane::rate).data(),
                                 gather(group_.inputs, &Lane::acceleration).data(), again.data());
    EXPECT_EQ(again, acceleration);
    return out;
  }
  // Along q' + side q''.
  static Quad curvature(const Lane& lane, Index equation, int side) {
    const auto f = [&](int s) {
      std::vector<Quad> q;
      for (std::size_t c = 0; c < lane.q.size(); ++c) {
        q.push_back(Quad(lane.q[c]) + s * (Quad(lane.rate[c]) + side * Quad(lane.acceleration[c])));
      }
      return residual<Quad>(lane.system, equation, q);
    };
    return f(1) + f(-1) - 2 * f(0);
  }
  [[nodiscard]] bool moves(Index coordinate) const {
    if (std::find(group_.unknowns.begin(), group_.unknowns.end(), coordinate) != group_.unknowns.end()) return true;
    const auto input = std::find(group_.inputs.begin(), group_.inputs.end(), coordinate);
    return input != group_.inputs.end() &&
           class_.input_moves[static_cast<std::size_t>(input - group_.inputs.begin())] != 0;
  }
  [[nodiscard]] std::vector<double> gather(const std::vector<Index>& slots, std::vector<double> Lane::*of) const {
    std::vector<double> out;
    for (const Index c : slots) {
      for (const Lane& lane : lanes_) out.push_back((lane.*of)[idx(c)]);
    }
    return out;
  }
  void check_row(const Lane& lane, Index equation, const Eigen::RowVectorXd& row, double bound) const {
    std::map<Index, double> g;
    gradient<double>(lane.system, equation, lane.q, [&](Index c, double v) { g[c] += v; });
    for (std::size_t c = 0; c < group_.unknowns.size(); ++c) {
      const auto found = g.find(group_.unknowns[c]);
      const double expected = found == g.end() ? 0 : found->second;
      EXPECT_NEAR(row[static_cast<Eigen::Index>(c)], expected, 16 * kEps * (bound + std::abs(expected)))
          << structure_.system->equation_name(equation) << " "
          << structure_.system->coordinate_name(group_.unknowns[c]);
    }
  }
  static Quad along(const Lane& lane, Index equation, int s) {
    std::vector<Quad> q;
    for (std::size_t c = 0; c < lane.q.size(); ++c) {
      q.push_back(Quad(lane.q[c]) + s * Quad(lane.rate[c]) + Quad(s * s) / 2 * Quad(lane.acceleration[c]));
    }
    return residual<Quad>(lane.system, equation, q);
  }

  const GroupedSystem& structure_;
  const SolvedGroup& group_;
  const GroupClass& class_;
  std::unique_ptr<Evaluator> evaluator_;
  std::size_t w_;
  std::vector<double> coefficients_;
  std::vector<Lane> lanes_;
};

TEST_P(EveryKind, ProgramAgreesInEveryLane) {
  for (const Formulation f : {global, groups, irreducible}) {
    const GroupedSystem s = look::structure(kind().scene, f);
    ASSERT_EQ(s.cannot_assemble, "");
    for (const SolvedGroup& g : s.groups) {
      for (const int lanes : {1, 2, 4, 8, 16}) Pack(s, g, lanes).check();
    }
  }
}

// ---- the whole run

// Tolerance: residuals of 1e-14 times a condition of 100. Each derivative is up to 10 times as large as the one before.
TEST_P(EveryKind, RunFollowsTheKnownMotion) {
  for (const char* strategy : {"global/eigen", "groups/eigen", "irreducible/eigen"}) {
    Simulator simulator(prepare(kind().scene, {strategy, {}}));
    const Trajectory run = simulator.run();
    ASSERT_TRUE(simulator.report().status.ok()) << strategy << " " << name(simulator.report().status.code);
    ASSERT_EQ(run.rows(), 9u);
    for (std::size_t row = 0; row < run.rows(); ++row) {
      for (const auto& [item, at] : kind().path(run.times()[row])) {
        const bool is_scalar = item.find('.') != std::string::npos && item.find(".across") == std::string::npos &&
                               item.find(".normal") == std::string::npos;
        const int components = is_scalar ? 1 : kind().scene.dimension();
        for (int k = 0; k < components; ++k) {
          const QuadJet& expected = at[static_cast<std::size_t>(k)];
          const auto value = [&, &of = item](const char* scalar, const std::string& part) {
            return run(row, run.index(is_scalar ? of + scalar : of + part + "xyz"[k]));
          };
          EXPECT_NEAR(value("", "."), static_cast<double>(expected.value), 1e-12) << item << strategy;
          EXPECT_NEAR(value(".rate", ".v"), static_cast<double>(expected.rate), 1e-11) << item << strategy;
          EXPECT_NEAR(value(".acceleration", ".a"), static_cast<double>(expected.acceleration), 1e-10)
              << item << strategy;
        }
      }
    }
  }
}

// Given lengths overrule the guess. They are refused if no triangle has them.
TEST(BodyOnThreePoints, RefusesLengthsWithoutTriangle) {
  SceneBuilder b("impossible", 3);
  b.point("A", {0, 0, 0}).point("B", {1, 0, 0}).point("C", {0, 1, 0});
  b.add(Body{"plate", "", {}, {"A", "B", "C"}, {{"M", {0.5, 0.5, 0.25}}}, {}});
  b.constrain("AB", Distance{"A", "B", 1.0}).constrain("BC", Distance{"C", "B", 3.0}).time(0, 1, 0.1);
  const Scene scene = b.build();
  EXPECT_EQ(look::error(Error::Kind::input, [&] { (void)lower(std::make_shared<const Scene>(scene)); }),
            "/bodies/plate/base: the distances between its three points do not form a triangle; each must be smaller "
            "than the "
            "sum of the others");
}

std::string test_name(const testing::TestParamInfo<Kind>& kind) {
  std::string out;
  for (const char c : kind.param.name) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) out += c;
    if (c == ' ') out += '_';
  }
  return out;
}
INSTANTIATE_TEST_SUITE_P(Plane, EveryKind, testing::ValuesIn(kinds::in_the_plane()), test_name);
INSTANTIATE_TEST_SUITE_P(Space, EveryKind, testing::ValuesIn(kinds::in_space()), test_name);

}  // namespace
}  // namespace assur
