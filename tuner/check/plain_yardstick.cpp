// The true motion by the plain equations, from the start posture of a run with all outputs.
#include <optional>

#include "assur/simulator.hpp"
#include "check/yardstick.hpp"
#include "decimal.hpp"
#include "mechanisms/plain_motion.hpp"
#include "plan/preparation.hpp"

namespace assur::check {
namespace {

using mechanisms::PlainMotion;

constexpr int kMoreCare = 8;  // care for a step that is repeated

class PlainTrueMotion final : public TrueMotion {
 public:
  explicit PlainTrueMotion(const Prepared& prepared)
      : scene_(prepared.scene()->with_outputs({})), motion_(scene_), before_(motion_) {
    const Simulator everything(prepare(scene_, {.strategy = "irreducible/eigen"}));
    const std::vector<double> row(everything.outputs().begin(), everything.outputs().end());
    from_ = now_ = everything.time();
    double figure = 0;
    switch (motion_.start(everything.columns(), row, laws_at(motion_.equations(), now_), figure)) {
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
    rows_.emplace(motion_, column_names(*preparation(prepared).structure->system));
  }

  [[nodiscard]] bool knows_turns(std::size_t column) const override { return rows_->knows_turns(column); }

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

  [[nodiscard]] double scale(int derivative) const override { return rows_->scale(derivative); }

 private:
  std::vector<long double> follow(double t) {
    const bool arrived = t == from_ || motion_.advance(from_, t) == 1;
    if (!arrived || !motion_.settle(laws_at(motion_.equations(), t))) {
      throw Error(Error::Kind::numerical,
                  "the motion computed for comparison does not reach t = " + general(t, 6) + " s");
    }
    now_ = t;
    return rows_->now();
  }

  Scene scene_;
  PlainMotion motion_, before_;
  std::optional<mechanisms::PlainRows> rows_;  // of motion_
  double from_ = 0, now_ = 0;
};

}  // namespace

std::unique_ptr<TrueMotion> plain_motion(const Prepared& prepared) {
  return std::make_unique<PlainTrueMotion>(prepared);
}

}  // namespace assur::check
