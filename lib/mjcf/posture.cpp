// Forward kinematics of the tree, and the postures in which its loops close.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "decimal.hpp"
#include "decompositions.hpp"
#include "mjcf/model.hpp"

namespace assur::mjcf {
namespace {

constexpr double kRounding = 1e-15;   // gap that is only rounding, relative to the size of the model
constexpr double kClosed = 1e-13;     // largest gap of a closed loop, relative to the size of the model
constexpr double kLargestStep = 0.3;  // rad, or sizes of the model
constexpr int kMostSteps = 200;       // a choice: at least 60 rad or sizes of the model
constexpr Eigen::Index kMostFreedoms = 2000, kMostEquations = 6000;  // the equations of a step are dense

// The equations of all loops, and how they change with the freedoms of the joints.
class Loops {
 public:
  explicit Loops(const Model& model) : model_(model) {
    for (const Joint& j : model.joints) {
      first_.push_back(freedoms_);
      freedoms_ += j.freedoms();
    }
    for (const Loop& l : model.loops) {
      rows_ += l.kind == Loop::Kind::connect ? 3 : l.kind == Loop::Kind::weld ? 6 : 1;
    }
    for (const Frame& f : posture(model, reference(model)).bodies) size_ = std::max(size_, f.at.norm());
    for (const Loop& l : model.loops) size_ = std::max({size_, l.frame1.at.norm(), l.frame2.at.norm()});
    if (size_ == 0) size_ = 1;
  }

  [[nodiscard]] double size() const { return size_; }
  [[nodiscard]] bool are_too_many() const { return freedoms_ > kMostFreedoms || rows_ > kMostEquations; }

  // Gaps in m; angles count with the size of the model.
  [[nodiscard]] Eigen::VectorXd gaps(const Values& q) const {
    const Posture now = posture(model_, q);
    Eigen::VectorXd gaps(rows_);
    Eigen::Index row = 0;
    for (const Loop& l : model_.loops) {
      if (l.kind == Loop::Kind::joint) {
        gaps[row++] =
            scale(l) * (value(q, l.joint1) - l.offset - (l.joint2 == kNone ? 0 : l.factor * value(q, l.joint2)));
        continue;
      }
      const Frame one = frame(now, l.body1) * l.frame1, other = frame(now, l.body2) * l.frame2;
      gaps.segment<3>(row) = other.at - one.at;
      row += 3;
      if (l.kind != Loop::Kind::weld) continue;
      Quaterniond turn = other.turn * one.turn.conjugate();
      if (turn.w() < 0) turn.coeffs() *= -1;
      const double sine = turn.vec().norm();
      gaps.segment<3>(row) = turn.vec() * size_ * (sine > 1e-8 ? 2 * std::atan2(sine, turn.w()) / sine : 2);
      row += 3;
    }
    return gaps;
  }

  [[nodiscard]] Eigen::MatrixXd slopes(const Values& q) const {
    const Posture now = posture(model_, q);
    Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(rows_, freedoms_);
    Eigen::Index row = 0;
    for (const Loop& l : model_.loops) {
      if (l.kind == Loop::Kind::joint) {
        slopes(row, column(l.joint1)) += scale(l);
        if (l.joint2 != kNone) slopes(row, column(l.joint2)) -= scale(l) * l.factor;
        ++row;
        continue;
      }
      const bool turns = l.kind == Loop::Kind::weld;
      add(now, l.body2, (frame(now, l.body2) * l.frame2).at, 1, turns, row, slopes);
      add(now, l.body1, (frame(now, l.body1) * l.frame1).at, -1, turns, row, slopes);
      row += turns ? 6 : 3;
    }
    return slopes;
  }

  [[nodiscard]] Values moved(const Values& q, const Eigen::VectorXd& by) const {
    Values next = q;
    for (std::size_t i = 0; i < model_.joints.size(); ++i) {
      const Joint& j = model_.joints[i];
      const Eigen::Index own = first_[i];
      if (j.has_coordinate()) {
        next[j.first] += by[own];
        continue;
      }
      std::size_t turn = j.first;
      Eigen::Index part = own;
      if (j.kind == Joint::Kind::free) {
        for (std::size_t k = 0; k < 3; ++k) next[turn++] += by[part++];
      }
      // A free body turns about axes of the world, a ball about axes of the body: see add().
      const Vector3d vector = by.segment<3>(part);
      const double angle = vector.norm();
      if (angle == 0) continue;
      const Quaterniond step(Eigen::AngleAxisd(angle, vector / angle));
      const Quaterniond old = Quaterniond(q[turn], q[turn + 1], q[turn + 2], q[turn + 3]).normalized();
      const Quaterniond fresh = (j.kind == Joint::Kind::free ? step * old : old * step).normalized();
      next[turn] = fresh.w(), next[turn + 1] = fresh.x(), next[turn + 2] = fresh.y(), next[turn + 3] = fresh.z();
    }
    return next;
  }

  // The loop with the largest gap.
  [[nodiscard]] std::pair<const Loop*, double> widest(const Eigen::VectorXd& gaps) const {
    std::pair<const Loop*, double> worst = {nullptr, -1};
    Eigen::Index row = 0;
    for (const Loop& l : model_.loops) {
      const Eigen::Index rows = l.kind == Loop::Kind::connect ? 3 : l.kind == Loop::Kind::weld ? 6 : 1;
      const double gap = gaps.segment(row, rows).norm();
      if (!(gap <= worst.second)) worst = {&l, gap};
      row += rows;
    }
    return worst;
  }

 private:
  static const Frame& frame(const Posture& p, int body) { return p.bodies[static_cast<std::size_t>(body)]; }
  [[nodiscard]] const Joint& joint(int j) const { return model_.joints[static_cast<std::size_t>(j)]; }
  [[nodiscard]] Eigen::Index column(int j) const { return first_[static_cast<std::size_t>(j)]; }
  [[nodiscard]] double value(const Values& q, int j) const { return q[joint(j).first] - joint(j).reference; }
  [[nodiscard]] double scale(const Loop& l) const { return joint(l.joint1).kind == Joint::Kind::hinge ? size_ : 1; }

  // The velocity of a point of a body, and the angular velocity of the body, for each freedom below it.
  void add(const Posture& now, int body, const Vector3d& point, double sign, bool turns, Eigen::Index row,
           Eigen::MatrixXd& slopes) const {
    for (; body != kWorld; body = model_.bodies[static_cast<std::size_t>(body)].parent) {
      for (const int i : model_.bodies[static_cast<std::size_t>(body)].joints) {
        const Joint& j = joint(i);
        const Vector3d &anchor = now.anchors[static_cast<std::size_t>(i)],
                       &axis = now.axes[static_cast<std::size_t>(i)];
        Eigen::Index c = column(i);
        const auto turn = [&](const Vector3d& about) {
          slopes.col(c).segment<3>(row) += sign * about.cross(point - anchor);
          if (turns) slopes.col(c).segment<3>(row + 3) += sign * size_ * about;
          ++c;
        };
        const auto slide = [&](const Vector3d& along) { slopes.col(c++).segment<3>(row) += sign * along; };
        if (j.kind == Joint::Kind::hinge) turn(axis);
        if (j.kind == Joint::Kind::slide) slide(axis);
        if (j.kind == Joint::Kind::free) {
          for (int k = 0; k < 3; ++k) slide(Vector3d::Unit(k));
          for (int k = 0; k < 3; ++k) turn(Vector3d::Unit(k));
        }
        if (j.kind == Joint::Kind::ball) {
          const Eigen::Matrix3d axes = now.turned[static_cast<std::size_t>(i)].toRotationMatrix();
          for (int k = 0; k < 3; ++k) turn(axes.col(k));
        }
      }
    }
  }

  const Model& model_;
  std::vector<Eigen::Index> first_;  // column of each joint
  Eigen::Index freedoms_ = 0, rows_ = 0;
  double size_ = 0;
};

}  // namespace

Values reference(const Model& model) {
  Values q(model.values, 0.0);
  for (const Joint& j : model.joints) {
    if (j.has_coordinate()) q[j.first] = j.reference;
    if (j.kind == Joint::Kind::ball) q[j.first] = 1;
    if (j.kind == Joint::Kind::free) {
      const Frame& f = model.bodies[static_cast<std::size_t>(j.body)].frame;
      const double values[] = {f.at.x(), f.at.y(), f.at.z(), f.turn.w(), f.turn.x(), f.turn.y(), f.turn.z()};
      std::copy(std::begin(values), std::end(values), q.begin() + static_cast<std::ptrdiff_t>(j.first));
    }
  }
  return q;
}

Posture posture(const Model& model, const Values& q) {
  Posture now;
  now.bodies.resize(model.bodies.size());
  now.anchors.resize(model.joints.size());
  now.axes.resize(model.joints.size());
  now.turned.resize(model.joints.size());
  for (std::size_t b = 1; b < model.bodies.size(); ++b) {
    const Body& body = model.bodies[b];
    Frame f = now.bodies[static_cast<std::size_t>(body.parent)] * body.frame;
    for (const int i : body.joints) {
      const Joint& j = model.joints[static_cast<std::size_t>(i)];
      const double* const values = q.data() + j.first;
      if (j.kind == Joint::Kind::free) {
        f.at = {values[0], values[1], values[2]};
        f.turn = Quaterniond(values[3], values[4], values[5], values[6]).normalized();
      }
      const Vector3d anchor = f * j.at, axis = f.turn * j.axis;
      if (j.kind == Joint::Kind::slide) f.at += axis * (values[0] - j.reference);
      if (j.kind == Joint::Kind::hinge)
        f.turn = f.turn * Quaterniond(Eigen::AngleAxisd(values[0] - j.reference, j.axis));
      if (j.kind == Joint::Kind::ball) f.turn = f.turn * Quaterniond(values[0], values[1], values[2], values[3]);
      f.turn.normalize();
      if (j.kind == Joint::Kind::hinge || j.kind == Joint::Kind::ball) f.at = anchor - f.turn * j.at;
      const std::size_t k = static_cast<std::size_t>(i);
      now.anchors[k] = anchor, now.axes[k] = axis, now.turned[k] = f.turn;
    }
    now.bodies[b] = f;
  }
  return now;
}

Change close(const Model& model, Values& q) {
  if (model.loops.empty()) return {};
  const Loops loops(model);
  const Values begin = q;
  Eigen::VectorXd gaps = loops.gaps(q);
  for (int step = 0; step < kMostSteps && gaps.lpNorm<Eigen::Infinity>() > kRounding * loops.size(); ++step) {
    if (loops.are_too_many()) {
      refuse(*loops.widest(gaps).first->node,
             "this loop is open in the start posture, and the joints have more than 2,000 freedoms, or the loops more "
             "than 6,000 equations, the limits for closing loops");
    }
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> slopes;
    slopes.setThreshold(1e-10);
    slopes.compute(loops.slopes(q));
    Eigen::VectorXd by = -slopes.solve(gaps);
    const double length = by.lpNorm<Eigen::Infinity>(), most = kLargestStep * std::min(1.0, loops.size());
    if (length > most) by *= most / length;
    bool better = false;
    for (int half = 0; half < 12 && !better; ++half, by /= 2) {
      const Values next = loops.moved(q, by);
      const Eigen::VectorXd left = loops.gaps(next);
      better = left.norm() < gaps.norm();
      if (better) q = next, gaps = left;
    }
    if (!better) break;
  }
  if (const auto [loop, gap] = loops.widest(gaps); !(gap <= kClosed * loops.size())) {
    refuse(*loop->node, "this loop cannot be closed; in the nearest posture to the start a gap of " + general(gap, 3) +
                            " m is left");
  }
  Change change;
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const Joint& j = model.joints[i];
    for (std::size_t k = j.first; k < j.first + j.values(); ++k) {
      if (std::abs(q[k] - begin[k]) > change.size) change = {std::abs(q[k] - begin[k]), static_cast<int>(i)};
    }
  }
  return change;
}

}  // namespace assur::mjcf
