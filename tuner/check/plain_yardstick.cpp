// The true motion by the plain equations, from the start posture of a run with all outputs.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "assur/simulator.hpp"
#include "check/plain_motion.hpp"
#include "check/yardstick.hpp"
#include "decimal.hpp"
#include "plan/preparation.hpp"

namespace assur::check {
namespace {

constexpr int kMoreCare = 8;  // care for a step that is repeated

class PlainTrueMotion final : public TrueMotion {
 public:
  explicit PlainTrueMotion(const Prepared& prepared)
      : scene_(prepared.scene()->with_outputs({})), motion_(scene_), before_(motion_) {
    const Simulator everything(prepare(scene_, {.strategy = "irreducible/eigen"}));
    const std::vector<double> row(everything.outputs().begin(), everything.outputs().end());
    double figure = 0;
    switch (motion_.start(everything.columns(), row, laws(everything.time(), 1), figure)) {
      case PlainMotion::Start::right:
        break;
      case PlainMotion::Start::off_law:
        throw Error(Error::Kind::numerical,
                    "at the start the angle of a driver differs from its law by " + std::to_string(figure));
      case PlainMotion::Start::off_equations:
        throw Error(Error::Kind::numerical, "at the start an equation is violated by " + std::to_string(figure));
      case PlainMotion::Start::singular:
        throw Error(Error::Kind::numerical, "the start posture is singular");
    }
    std::vector<PlainEquations::Column> angles;
    for (const std::string& name : column_names(*preparation(prepared).structure->system)) {
      columns_.push_back(motion_.equations().column(name));
      angle_.push_back(columns_.back().signed_angle ? static_cast<int>(angles.size()) : -1);
      if (columns_.back().signed_angle) angles.push_back(columns_.back());
    }
    motion_.follow(std::move(angles));
    from_ = now_ = everything.time();
  }

  [[nodiscard]] bool knows_turns(std::size_t column) const override {
    return angle_[column] >= 0 && motion_.knows_turns(static_cast<std::size_t>(angle_[column]));
  }

  std::vector<long double> row(std::size_t, double t) override {
    before_ = motion_;
    from_ = now_;
    return follow(t);
  }
  std::vector<long double> row_again(std::size_t, double t) override {
    motion_ = before_;
    motion_.take_care(kMoreCare);
    std::vector<long double> out = follow(t);
    motion_.take_care(1);
    return out;
  }

  [[nodiscard]] double scale(int derivative) const override { return scale_[derivative]; }

 private:
  // The laws with derivatives with respect to s; one unit of s is `seconds` long.
  [[nodiscard]] std::vector<TimeJet<Real>> laws(Real t, Real seconds) const {
    std::vector<TimeJet<Real>> out;
    for (const Law* law : motion_.equations().laws()) {
      const TimeJet<Real> l = value_of(*law, t);
      out.emplace_back(l.value, l.rate * seconds, l.curve * seconds * seconds);
    }
    return out;
  }

  std::vector<long double> follow(double t) {
    const Real begin = from_, seconds = static_cast<Real>(t) - begin;
    const bool arrived =
        seconds == 0 || motion_.advance([&](Real s) { return laws(begin + s * seconds, seconds); }) == 1;
    if (!arrived || !motion_.settle(laws(t, 1))) {
      throw Error(Error::Kind::numerical,
                  "the motion computed for comparison does not reach t = " + general(t, 6) + " s");
    }
    now_ = t;
    const double rate = motion_.scale(1) / (2 * std::numbers::pi);
    scale_[1] = std::max(scale_[1], rate);
    scale_[2] = std::max({scale_[2], motion_.scale(2) / std::pow(2 * std::numbers::pi, 2), rate * rate});
    std::vector<long double> out;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const TimeJet<Real> jet = columns_[i].known ? motion_.show(columns_[i]) : TimeJet<Real>(NAN, NAN, NAN);
      const int d = columns_[i].derivative;
      out.push_back(angle_[i] >= 0 ? motion_.turned(static_cast<std::size_t>(angle_[i]))
                    : d == 0       ? jet.value
                    : d == 1       ? jet.rate
                                   : jet.curve);
    }
    return out;
  }

  Scene scene_;
  PlainMotion motion_, before_;
  std::vector<PlainEquations::Column> columns_;
  std::vector<int> angle_;
  double from_ = 0, now_ = 0;
  double scale_[3] = {1, 0, 0};
};

}  // namespace

std::unique_ptr<TrueMotion> plain_motion(const Prepared& prepared) {
  return std::make_unique<PlainTrueMotion>(prepared);
}

}  // namespace assur::check
