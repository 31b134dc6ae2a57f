// The true motion in quadruple precision.
#include <cmath>
#include <numbers>

#include "check/yardstick.hpp"
#include "outputs/output_program.hpp"
#include "verification/reference_motion.hpp"

namespace assur::check {
namespace {

constexpr int kPieces = 16;  // parts of a step that is repeated

class QuadMotion final : public TrueMotion {
 public:
  explicit QuadMotion(const Prepared& prepared)
      : motion_(prepared), outputs_(wanted_outputs(motion_.system())), before_(motion_.state()) {}

  std::vector<long double> row(std::size_t, double t) override {
    before_ = motion_.state();
    motion_.advance(t);
    for (const int d : {1, 2}) scale_[d] = std::max(scale_[d], motion_.scale(d) / std::pow(2 * std::numbers::pi, d));
    return values();
  }

  std::vector<long double> row_again(std::size_t, double t) override {
    motion_.restore(before_);
    motion_.advance(t, kPieces);
    return values();
  }

  [[nodiscard]] double scale(int derivative) const override { return scale_[derivative]; }

 private:
  std::vector<long double> values() const {
    std::vector<long double> out;
    for (const Output& o : outputs_) {
      std::vector<Jet<Quad>> jets;
      for (const OutputPart& part : o.parts()) jets.push_back(o.sum != nullptr ? jet(*o.sum) : jet(part));
      for (const int d : {0, 1, 2}) {
        if (!o.wanted[d]) continue;
        for (const Jet<Quad>& jet : jets) {
          out.push_back(static_cast<long double>(d == 0 ? jet.value : d == 1 ? jet.rate : jet.acceleration));
        }
      }
    }
    return out;
  }

  [[nodiscard]] Jet<Quad> jet(const MeasureForms& sum) const {
    Jet<Quad> total{Quad(sum.constant.value()), 0, 0};
    for (const auto& [measure, factor] : sum.terms) {
      const MeasureForms& m = motion_.system().measures[static_cast<std::size_t>(measure)];
      total = total + Quad(factor.value()) * jet(OutputPart{m.kind, m.dimension, m.forms});
    }
    return total;
  }

  [[nodiscard]] Jet<Quad> jet(const OutputPart& part) const {
    const System& s = motion_.system();
    Jet<Quad> forms[9];
    for (std::size_t f = 0; f < part.forms.size(); ++f) {
      const auto of = [&](std::size_t d) { return form_value<Quad>(s, part.forms[f], motion_.state().q[d]); };
      forms[f] = {of(0), of(1), of(2)};
    }
    return evaluate_measure<Quad>(part.kind, {forms, 9}, s.dimension) * Quad(s.unit(part.dimension));
  }

  ReferenceMotion motion_;
  std::vector<Output> outputs_;
  ReferenceMotion::State before_;
  double scale_[3] = {1, 0, 0};
};

}  // namespace

std::unique_ptr<TrueMotion> reference_motion(const Prepared& prepared) {
  return std::make_unique<QuadMotion>(prepared);
}

}  // namespace assur::check
