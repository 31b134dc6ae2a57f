#include "start/walk.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <utility>

#include "decompositions.hpp"
#include "equations/dense_block.hpp"
#include "equations/drive.hpp"
#include "equations/own_values.hpp"
#include "index.hpp"
#include "numbers.hpp"

namespace assur {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kHagerRounds = 4;  // a choice: Hager's estimate usually ends after two
constexpr int kForecast = 5000;  // steps after which a way is given up that would take four times as many as allowed
constexpr double kLeastForecast = kForecast / (4.0 * kMostWalkedSteps);  // share of the way after kForecast steps
// rad or internal units; nearer to a singular posture, rounding decides
constexpr double kShortest = 1e-10;
constexpr double kDriverSlack = 1e-6;  // relative; a direction that has passed through zero is off by half a turn
constexpr double kProbe = 1e-6;        // internal units: displacement that measures the curvature of a function
constexpr double kMeasured = 2;        // margin of bounds that are measured; a choice
constexpr double kOverChangePoint[] = {1e-3, 1e-2, 5e-2};  // rad or internal units: half of a step over a change point
constexpr double kInBall = 0.05;                           // the same, times the curvature
constexpr std::size_t kMostKept = 512, kLeastKept = 8, kKeptNumbers = 1 << 22;  // postures behind the current one

// An inverse of the Jacobian of one part at one posture. If there are more equations than unknowns: of the normal
// equations, or, with residuals, of the second derivatives of half their sum of squares. (Where equations contradict
// each other, Newton's method without the curvature of the residuals hardly converges.)
class Inverse {
 public:
  Inverse(const DenseBlock& block, const std::vector<double>& q, const VectorXd* residuals = nullptr) {
    const bool is_square = block.rows() == block.columns();
    if (block.rows() < block.columns()) return;
    Eigen::SparseMatrix<double> curvature;
    if (!is_square && residuals != nullptr) curvature = block.weighted_curvature(*residuals);
    if (block.columns() <= kLargestDenseLu) {
      const MatrixXd j = block.jacobian(q);
      if (!j.allFinite()) return;
      if (is_square) {
        dense_ = j.partialPivLu().inverse();
      } else {
        const Eigen::ColPivHouseholderQR<MatrixXd> qr(j);
        if (qr.rank() < j.cols()) return;
        dense_ = qr.solve(MatrixXd::Identity(j.rows(), j.rows()));
        if (curvature.nonZeros() > 0) {
          const MatrixXd bent = MatrixXd::Identity(j.cols(), j.cols()) + dense_ * (dense_.transpose() * curvature);
          dense_ = bent.partialPivLu().solve(dense_);
        }
      }
      ok_ = dense_.allFinite();
      return;
    }
    sparse_ = std::make_unique<Sparse>();
    Sparse& s = *sparse_;
    s.is_square = is_square;
    s.jacobian = block.sparse_jacobian(q);
    s.jacobian.makeCompressed();
    if (is_square) {
      s.lu.compute(s.jacobian);
      const Eigen::SparseMatrix<double> transposed = s.jacobian.transpose();
      s.lu_transposed.compute(transposed);
      ok_ = s.lu.info() == Eigen::Success && s.lu_transposed.info() == Eigen::Success;
    } else {
      Eigen::SparseMatrix<double> normal = s.jacobian.transpose() * s.jacobian;
      if (curvature.nonZeros() > 0) normal += curvature;
      s.normal.compute(normal);
      ok_ = s.normal.info() == Eigen::Success;
    }
  }

  [[nodiscard]] bool ok() const { return ok_; }

  [[nodiscard]] VectorXd solve(const VectorXd& b) const {
    if (!sparse_) return dense_ * b;
    if (sparse_->is_square) return sparse_->lu.solve(b);
    return sparse_->normal.solve(sparse_->jacobian.transpose() * b);
  }

  // The largest component of |C| g for g >= 0; for large parts Hager's estimate of the norm of C diag(g) (Higham,
  // Accuracy and Stability of Numerical Algorithms, 2002, algorithm 15.1).
  [[nodiscard]] double norm(const VectorXd& g) const {
    if (!g.allFinite()) return kInfinity;
    if (!sparse_) return g.size() == 0 ? 0 : (dense_.cwiseAbs() * g).maxCoeff();
    const Eigen::Index n = sparse_->jacobian.cols();
    VectorXd x = VectorXd::Constant(n, 1 / static_cast<double>(n));  // of the transpose, whose 1-norm is wanted
    double estimate = 0;
    for (int round = 0; round < kHagerRounds; ++round) {
      const VectorXd y = g.cwiseProduct(solve_transposed(x));
      const double now = y.lpNorm<1>();
      if (!(now > estimate)) break;
      estimate = now;
      const VectorXd signs = y.unaryExpr([](double v) { return v < 0 ? -1.0 : 1.0; });
      const VectorXd z = solve(g.cwiseProduct(signs));
      Eigen::Index at = 0;
      if (round > 0 && z.cwiseAbs().maxCoeff(&at) <= z.dot(x)) break;
      (void)z.cwiseAbs().maxCoeff(&at);
      x = VectorXd::Unit(n, at);
    }
    return estimate;
  }

 private:
  struct Sparse {
    bool is_square = true;
    Eigen::SparseMatrix<double> jacobian;
    Eigen::SparseLU<Eigen::SparseMatrix<double>> lu, lu_transposed;
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> normal;
  };

  [[nodiscard]] VectorXd solve_transposed(const VectorXd& b) const {
    if (sparse_->is_square) return sparse_->lu_transposed.solve(b);
    return sparse_->jacobian * sparse_->normal.solve(b);
  }

  bool ok_ = false;
  MatrixXd dense_;
  std::unique_ptr<Sparse> sparse_;  // null: dense
};

// A posture on the way.
struct Posture {
  double s = 0;
  std::vector<double> q, rate;  // all coordinates; rate: by s
  std::vector<double> bend;     // second derivative by s, for the prediction
};

class Walk : WalkRules {
 public:
  Walk(const System& system, const std::vector<WalkedPart>& parts, const WalkPath& way)
      : s_(system),
        parts_(parts),
        way_(way),
        driven_(all_driven(system)),
        column_(system.coordinates.size(), -1),
        off_(system.coordinates.size(), 0),
        is_left_(parts.size(), 0),
        length_(std::max(1.0, length())) {}

  Walked run(std::vector<double>& q) {
    Posture at;
    at.q = q;
    at.rate.assign(q.size(), 0);
    at.bend = at.rate;
    double h = 1;
    Walked out;
    while (!begin(at)) {
      if (leave_part()) continue;
      out.end = Walked::End::singular;
      out.part = failed_;
      return out;
    }
    while (at.s < 1) {
      out.end = advance(at, 1, h, true);
      if (out.end == Walked::End::arrived) break;
      const bool may_pass = out.end == Walked::End::singular && way_.passes && way_.open.empty();
      const std::size_t part = failed_;
      if (may_pass && pass(at, out)) continue;
      failed_ = part;
      if (out.end != Walked::End::singular || !leave_part()) break;
      h = 1 - at.s;
    }
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      if (is_left_[k] != 0) out.left.push_back(k);
    }
    out.share = at.s;
    out.steps = steps_;
    out.part = failed_;
    out.driver = vanished_;
    q = std::move(at.q);
    return out;
  }

 private:
  // The longest change of a driver, rad or internal units.
  [[nodiscard]] double length() const {
    double longest = 0;
    for (std::size_t i = 0; i < s_.inputs.size(); ++i) {
      for (std::size_t k = 0; k < way_.change[i].size(); ++k) {
        const DriverInput& in = s_.inputs[i];
        const double unit = is_angle(s_, in, k) ? 1 : s_.unit(in.dimension);
        longest = std::max(longest, std::abs(way_.change[i][k]) / unit);
      }
    }
    return longest;
  }

  [[nodiscard]] double shortest() const { return kShortest / length_; }

  // Known coordinates at s, and their rates where not null.
  void drive_at(double s, std::vector<double>& q, double* rate) const {
    drive<double>(
        s_, driven_,
        [&](std::size_t i, int k) {
          const double change = way_.change[i][idx(k)];
          return Jet<double>{way_.from[i][idx(k)] + s * change, change, 0};
        },
        q.data(), rate, nullptr);
  }

  [[nodiscard]] DenseBlock block(const WalkedPart& p) { return {s_, p.equations, p.unknowns, column_}; }

  // Residuals that must vanish at s.
  [[nodiscard]] VectorXd residuals(const WalkedPart& p, double s, const std::vector<double>& q) {
    VectorXd phi = block(p).residuals(q);
    for (Eigen::Index i = 0; i < phi.size() && !way_.open.empty(); ++i) {
      phi[i] -= (1 - s) * way_.open[idx(p.equations[static_cast<std::size_t>(i)])];
    }
    return phi;
  }

  // Rates of the unknowns of a part, from those of all coordinates that it reads.
  void set_rates(const WalkedPart& p, const Inverse& inverse, const std::vector<double>& q, std::vector<double>& rate) {
    for (const Index u : p.unknowns) rate[idx(u)] = 0;
    VectorXd by_inputs(static_cast<Eigen::Index>(p.equations.size()));
    for (Eigen::Index i = 0; i < by_inputs.size(); ++i) {
      const Index e = p.equations[static_cast<std::size_t>(i)];
      double sum = way_.open.empty() ? 0 : way_.open[idx(e)];
      gradient<double>(s_, e, q, [&](Index c, double value) { sum += value * rate[idx(c)]; });
      by_inputs[i] = sum;
    }
    const VectorXd v = -inverse.solve(by_inputs);
    for (Eigen::Index i = 0; i < v.size(); ++i) rate[idx(p.unknowns[static_cast<std::size_t>(i)])] = v[i];
  }

  // Leaves the part that failed, and all that read it, where they are. False if one of them is needed.
  bool leave_part() {
    if (failed_ >= parts_.size() || parts_[failed_].is_needed) return false;
    std::vector<std::uint8_t> stays(off_.size(), 0);
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      const WalkedPart& p = parts_[k];
      const bool reads = std::any_of(p.equations.begin(), p.equations.end(), [&](Index e) {
        s_.mentioned(e, mentioned_);
        return std::any_of(mentioned_.begin(), mentioned_.end(), [&](Index c) { return stays[idx(c)] != 0; });
      });
      if (k != failed_ && !reads) continue;
      if (p.is_needed) return false;
      is_left_[k] = 1;
      for (const Index u : p.unknowns) stays[idx(u)] = 1;
    }
    return true;
  }

  bool begin(Posture& at) {
    drive_at(at.s, at.q, at.rate.data());
    for (failed_ = 0; failed_ < parts_.size(); ++failed_) {
      if (is_left_[failed_] != 0) continue;
      const WalkedPart& p = parts_[failed_];
      const Inverse inverse(block(p), at.q);
      if (!inverse.ok()) return false;
      set_rates(p, inverse, at.q, at.rate);
    }
    return true;
  }

  // Moves to `until` in steps of about h. arrived: q is there; else the last posture is kept.
  Walked::End advance(Posture& at, double until, double& h, bool keeps) {
    while (at.s < until) {
      if (++steps_ > kMostWalkedSteps || (steps_ == kForecast && at.s < kLeastForecast)) return Walked::End::too_long;
      const double target = until - at.s <= h * (1 + 16 * kEps) ? until : at.s + h;
      Posture next;
      const double use = step(at, target, next);
      if (use <= kSurest) {
        next.bend.resize(at.q.size());
        const double by = target - at.s;
        for (std::size_t c = 0; c < next.bend.size(); ++c) next.bend[c] = (next.rate[c] - at.rate[c]) / by;
        std::swap(at, next);
        if (keeps) keep(std::move(next));
        h = by * after_success(use);
        continue;
      }
      h = (target - at.s) * after_failure(use);
      if (!(h >= shortest())) return vanished_ >= 0 ? Walked::End::vanished : Walked::End::singular;
    }
    return Walked::End::arrived;
  }

  void keep(Posture&& p) {
    kept_.push_back(std::move(p));
    const std::size_t most = std::clamp(kKeptNumbers / s_.coordinates.size(), kLeastKept, kMostKept);
    if (kept_.size() > most) kept_.pop_front();
  }

  // Finds the posture at `target`. Returns the largest share of the bound of the test that a part uses; above 1 if
  // there is no proof.
  double step(const Posture& from, double target, Posture& to) {
    vanished_ = -1;
    const double h = target - from.s;
    to.s = target;
    to.q = from.q;
    to.rate.assign(from.q.size(), 0);
    drive_at(target, to.q, to.rate.data());
    set_strays(s_, way_, h, off_);
    double most = 0;
    for (failed_ = 0; failed_ < parts_.size(); ++failed_) {
      if (is_left_[failed_] != 0) continue;
      const WalkedPart& p = parts_[failed_];
      for (const Index u : p.unknowns) to.q[idx(u)] += h * (from.rate[idx(u)] + h / 2 * from.bend[idx(u)]);
      if (!correct(p, target, to)) return kInfinity;
      const double use = test(p, from, to);
      if (!(use <= kSurest)) return use > 0 ? use : kInfinity;
      most = std::max(most, use);
    }
    failed_ = 0;
    return drivers_hold(to.q) ? most : kInfinity;
  }

  // Newton's method, and the rates of the part.
  bool correct(const WalkedPart& p, double s, Posture& at) {
    double last = kInfinity;
    for (int k = 0; k < kMostCorrections; ++k) {
      const VectorXd left = residuals(p, s, at.q);
      const Inverse inverse(block(p), at.q, &left);
      if (!inverse.ok()) return false;
      const VectorXd by = inverse.solve(left);
      const double size = by.size() == 0 ? 0 : by.lpNorm<Eigen::Infinity>();
      if (!(size < last / 2) && !(size <= kRoundingOnly)) return false;
      for (Eigen::Index i = 0; i < by.size(); ++i) at.q[idx(p.unknowns[static_cast<std::size_t>(i)])] -= by[i];
      if (size <= kCorrected || !(size < last / 2)) {
        set_rates(p, inverse, at.q, at.rate);
        return true;
      }
      last = size;
    }
    return false;
  }

  // Sums that bound the change of a row: |Q|(a, b) = sum of |constant| (|form a|(a) |form b|(b) + |form a|(b) |form
  // b|(a)) for steps a and b of the coordinates, where b is 1 for the unknowns of the part and 0 for all others.
  struct Bounds {
    VectorXd by_chord, by_ball, by_inputs;
  };

  [[nodiscard]] double size_of(Index form, const std::vector<double>& steps) const {
    double sum = 0;
    for (const Term& t : s_.form(form)) sum += std::abs(s_.constants[idx(t.constant)]) * steps[idx(t.coordinate)];
    return sum;
  }

  [[nodiscard]] double in_part(Index form) const {
    double sum = 0;
    for (const Term& t : s_.form(form)) {
      if (column_[idx(t.coordinate)] >= 0) sum += std::abs(s_.constants[idx(t.constant)]);
    }
    return sum;
  }

  // The same for a function of the program, from its Jacobian around the middle.
  void measure(Index e, const Posture& from, const Posture& to, const std::vector<double>& middle, double& by_chord,
               double& by_ball) {
    s_.mentioned(e, mentioned_);
    double chord = 0, off = 0;
    for (const Index c : mentioned_) {
      chord = std::max(chord, std::abs(to.q[idx(c)] - from.q[idx(c)]) / 2);
      off = std::max(off, off_[idx(c)]);
    }
    const auto slopes = [&](const std::vector<double>& q, std::vector<double>& at) {
      at.assign(mentioned_.size(), 0);
      gradient<double>(s_, e, q, [&](Index c, double value) {
        const auto place = std::lower_bound(mentioned_.begin(), mentioned_.end(), c);
        if (place != mentioned_.end() && *place == c) at[static_cast<std::size_t>(place - mentioned_.begin())] += value;
      });
    };
    double most = 0;
    std::vector<double> there = middle, here, beside;
    slopes(middle, here);
    for (int pattern = 0; pattern < 6; ++pattern) {
      const double probe = pattern < 3 ? kProbe : std::max(kProbe, chord + off);
      for (std::size_t k = 0; k < mentioned_.size(); ++k) {
        const std::size_t c = idx(mentioned_[k]);
        const double along = chord > 0 ? (to.q[c] - from.q[c]) / (2 * chord) : 0;
        const bool plus = ((k * 7 + idx(pattern % 3) * 3) / 2) % 2 == 0;
        there[c] = middle[c] + probe * (pattern % 3 == 0 ? along : plus ? 1 : -1);
      }
      slopes(there, beside);
      double sum = 0;
      for (std::size_t k = 0; k < mentioned_.size(); ++k) {
        const double change = std::abs(beside[k] - here[k]);
        if (!std::isfinite(change)) sum = kInfinity;
        if (column_[idx(mentioned_[k])] >= 0) sum += change;
      }
      most = std::max(most, kMeasured * sum / probe);
    }
    by_chord = most * (chord + off);
    by_ball = most;
  }

  // The test of one part along the chord between two postures: see walk.hpp. Returns Z1 + 2 sqrt(B Y), which must be
  // below 1, and sets off_ of the unknowns.
  double test(const WalkedPart& p, const Posture& from, const Posture& to) {
    middle_.resize(from.q.size());
    half_.resize(from.q.size());
    const auto n = static_cast<Eigen::Index>(p.equations.size());
    for (std::size_t k = 0; k < p.unknowns.size(); ++k) off_[idx(p.unknowns[k])] = 0;
    for (const Index e : p.equations) {
      s_.mentioned(e, mentioned_);
      for (const Index c : mentioned_) {
        middle_[idx(c)] = from.q[idx(c)] + (to.q[idx(c)] - from.q[idx(c)]) / 2;
        half_[idx(c)] = std::abs(to.q[idx(c)] - from.q[idx(c)]) / 2 + off_[idx(c)];
      }
    }
    middle_[idx(kOne)] = from.q[idx(kOne)];
    half_[idx(kOne)] = 0;
    const Inverse inverse(block(p), middle_);
    if (!inverse.ok()) return kInfinity;
    // On the chord the residuals are those of its ends plus 4 t (1 - t) times those in the middle.
    VectorXd chord = residuals(p, from.s + (to.s - from.s) / 2, middle_);
    VectorXd by_chord(n), by_ball(n), by_inputs(n);
    for (std::size_t k = 0; k < p.unknowns.size(); ++k) column_[idx(p.unknowns[k])] = static_cast<Index>(k);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Index e = p.equations[static_cast<std::size_t>(i)];
      const Equation& equation = s_.equations[idx(e)];
      double inputs = 0;
      gradient<double>(s_, e, middle_, [&](Index c, double value) { inputs += std::abs(value) * off_[idx(c)]; });
      double z = 0, b = 0;
      if (equation.callback >= 0) {
        measure(e, from, to, middle_, z, b);
        chord[i] *= kMeasured;
        inputs *= kMeasured;
      }
      for (const Product& product : s_.products_of(equation)) {
        const double c = std::abs(s_.constants[idx(product.constant)]);
        const double a1 = in_part(product.a), b1 = in_part(product.b);
        const double ah = size_of(product.a, half_), bh = size_of(product.b, half_);
        z += c * (ah * b1 + a1 * bh);
        b += c * a1 * b1;
        inputs += c * (ah * size_of(product.b, off_) + size_of(product.a, off_) * bh);
      }
      by_chord[i] = z;
      by_ball[i] = b;
      by_inputs[i] = inputs;
    }
    for (const Index u : p.unknowns) column_[idx(u)] = -1;
    const auto size = [](const VectorXd& x) { return x.size() == 0 ? 0.0 : x.lpNorm<Eigen::Infinity>(); };
    const double y = size(inverse.solve(chord)) + size(inverse.solve(residuals(p, from.s, from.q))) +
                     size(inverse.solve(residuals(p, to.s, to.q))) + inverse.norm(by_inputs);
    const double z = inverse.norm(by_chord), b = inverse.norm(by_ball);
    const double use = z + 2 * std::sqrt(b * y);
    curvature_ = b;
    if (!(use <= kSurest)) return use;
    const double radius = 2 * y / (1 - z + std::sqrt((1 - z) * (1 - z) - 4 * b * y));
    const double h = to.s - from.s;
    for (const Index u : p.unknowns) {
      // The cubic with these rates at both ends leaves its chord by at most 4 / 27 of this sum.
      const double by = to.q[idx(u)] - from.q[idx(u)];
      const double bent = std::abs(h * from.rate[idx(u)] - by) + std::abs(h * to.rate[idx(u)] - by);
      off_[idx(u)] = std::min(radius, kMeasured * bent * 4 / 27);
    }
    return use;
  }

  // False if a lever is not positive, or if a driver has not its value any more, because its direction has vanished.
  bool drivers_hold(const std::vector<double>& q) {
    for (const Positive& p : s_.positive) {
      if (q[idx(p.coordinate)] > 0) continue;
      vanished_ = p.driver;
      return false;
    }
    return !way_.open.empty() || assur::drivers_hold(s_, way_, q, &vanished_);
  }

  // Passes a change point by the smooth continuation: a cubic through four postures before it predicts a posture behind
  // it, as in a run (motion/failed_step.cpp). At a fold there is no posture behind.
  bool pass(Posture& at, Walked& out) {
    const double change = at.s;
    const std::size_t part = failed_;
    for (const double over : kOverChangePoint) {
      const double reach = over / length_, behind = std::min(reach, 1 - change);
      if (behind < reach / 16) continue;
      const auto before =
          std::find_if(kept_.rbegin(), kept_.rend(), [&](const Posture& p) { return p.s <= change - reach; });
      if (before == kept_.rend()) return false;
      Posture p = *before;
      std::vector<Posture> way;
      double h = reach / 4;
      for (const double share : {1.0, 0.75, 0.5, 0.25}) {
        if (advance(p, change - share * reach, h, false) != Walked::End::arrived) break;
        way.push_back(p);
      }
      if (way.size() < 4) continue;
      Posture next;
      next.s = change + behind;
      next.q = at.q;
      next.rate.assign(at.q.size(), 0);
      next.bend = next.rate;
      if (!arrives(at, way, next)) continue;
      at = std::move(next);
      kept_.clear();
      out.passed.push_back({change, part});
      return true;
    }
    return false;
  }

  bool arrives(const Posture& at, const std::vector<Posture>& way, Posture& next) {
    drive_at(next.s, next.q, next.rate.data());
    double weight[4];
    for (std::size_t i = 0; i < 4; ++i) {
      weight[i] = 1;
      for (std::size_t j = 0; j < 4; ++j) {
        if (j != i) weight[i] *= (next.s - way[j].s) / (way[i].s - way[j].s);
      }
    }
    std::vector<double> predicted = next.q;
    double moved = 0, corrected = 0;
    for (failed_ = 0; failed_ < parts_.size(); ++failed_) {
      if (is_left_[failed_] != 0) continue;
      const WalkedPart& p = parts_[failed_];
      for (const Index u : p.unknowns) {
        double sum = 0;
        for (std::size_t i = 0; i < 4; ++i) sum += weight[i] * way[i].q[idx(u)];
        predicted[idx(u)] = next.q[idx(u)] = sum;
      }
      if (!correct(p, next.s, next)) return false;
      double correction = 0;
      for (const Index u : p.unknowns) {
        moved = std::max(moved, std::abs(next.q[idx(u)] - at.q[idx(u)]));
        correction = std::max(correction, std::abs(next.q[idx(u)] - predicted[idx(u)]));
      }
      corrected = std::max(corrected, correction);
      set_strays(s_, way_, 0, off_);
      (void)test(p, next, next);
      if (!(correction * curvature_ <= kInBall)) return false;
    }
    return corrected <= WalkRules::kSureOfBranch * moved && drivers_hold(next.q);
  }

  const System& s_;
  const std::vector<WalkedPart>& parts_;
  const WalkPath& way_;
  Driven driven_;
  std::vector<Index> column_;          // scratch of DenseBlock
  std::vector<double> off_;            // coordinates: how far they may leave their chords in the step that is tested
  std::vector<std::uint8_t> is_left_;  // parts
  double length_;
  std::vector<double> middle_, half_;
  std::vector<Index> mentioned_;
  double curvature_ = 0;    // of the part that was tested last
  std::size_t failed_ = 0;  // part at which the last attempt failed
  Index vanished_ = -1;     // driver whose direction vanished in the last attempt
  int steps_ = 0;
  std::deque<Posture> kept_;
};

}  // namespace

void set_strays(const System& s, const WalkPath& way, double share, std::vector<double>& off) {
  for (std::size_t i = 0; i < s.inputs.size(); ++i) {
    const DriverInput& in = s.inputs[i];
    double turn = 0;
    for (std::size_t k = 0; k < way.change[i].size(); ++k) {
      if (is_angle(s, in, static_cast<int>(k))) turn += std::abs(share * way.change[i][k]);
    }
    const double most = std::min(2.0, turn * turn / 8);  // of cosines, and of the axes of a frame
    for (Index c = 0; c < in.count; ++c) {
      const bool turns =
          in.kind == DriverInput::Kind::direction || (in.kind == DriverInput::Kind::frame && c >= s.dimension);
      off[idx(in.first + c)] = turns ? most : 0;
    }
  }
  for (const Assignment& a : s.assignments) {
    double sum = 0;
    for (const Term& t : s.form(a.form)) sum += std::abs(s.constants[idx(t.constant)]) * off[idx(t.coordinate)];
    off[idx(a.coordinate)] = sum;
  }
}

bool drivers_hold(const System& s, const WalkPath& way, const std::vector<double>& q, Index* driver) {
  for (std::size_t i = 0; i < s.inputs.size(); ++i) {
    const DriverInput& in = s.inputs[i];
    const bool moves = std::any_of(way.change[i].begin(), way.change[i].end(), [](double c) { return c != 0; });
    if (!moves || in.kind == DriverInput::Kind::frame) continue;
    if (has_its_value(s, in, q, kDriverSlack)) continue;
    if (driver != nullptr) *driver = in.driver;
    return false;
  }
  return true;
}

Walked walk(const System& system, const std::vector<WalkedPart>& parts, const WalkPath& way, std::vector<double>& q) {
  return Walk(system, parts, way).run(q);
}

}  // namespace assur
