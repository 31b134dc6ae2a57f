// Compiled once for each SIMD target; make_box_test() chooses the target.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "groups/box_test.cpp"
#include <hwy/foreach_target.h>  // must precede the code compiled for each target

#include "evaluation/lane_vector-inl.hpp"
#include "evaluation/quadratic_equations-inl.hpp"

#include "groups/box_test.hpp"

#include <limits>

#include "index.hpp"
#include "program/step_rules.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {
namespace {

constexpr int kGrowths = 20;           // attempts to enlarge a box until it contains its image
constexpr double kRadiusGrowth = 1.2;  // in one attempt; a choice
// Margins for the postures between the examined ones.
constexpr double kDefectBetween = 1.5, kChangeBetween = 1.25;
// Residuals below this are only rounding, with a margin: at a change point they decide between the branches.
constexpr double kRoundingOfBranch = 64 * kConverged;

class BoxTestOf final : public BoxTest {
  static constexpr int W = static_cast<int>(kPostures);
  using L = Lanes<W>;
  using Array = typename L::Array;

  static HWY_INLINE L of_lane(const Lane& of, const double* numbers, std::int32_t i) {
    return L::set(numbers[i * of.lanes + of.lane]);
  }
  static HWY_INLINE auto coefficients(const Lane& of) {
    return [&of](std::int32_t i) HWY_ATTR { return of_lane(of, of.coefficients, i); };
  }

 public:
  explicit BoxTestOf(const GroupClass& group_class) : class_(group_class), equations_(group_class) {}

  void take(const Lane& of, const double* unknowns, const double* inputs) override {
    const auto k = coefficients(of);
    const auto into = [](Array& to) { return [&to](std::size_t i, const L& x) HWY_ATTR { to.set(i, x); }; };
    equations_.set_inputs(k, [inputs](std::int32_t i) HWY_ATTR { return L::load(inputs + i * W); });
    for (std::int32_t j = 0; j < class_.n; ++j) equations_.values().set(idx(j), L::load(unknowns + j * W));
    equations_.evaluate(k, into(phi_));
    equations_.differentiate(k, [&](std::size_t e, const L& there) HWY_ATTR {
      change_.set(e, L::set(kChangeBetween) * abs(of_lane(of, of.jacobian, static_cast<std::int32_t>(e)) - there));
    });
    equations_.scale(k, into(scale_));
  }
  void take(const Lane& of, const double* phi, const double* scale, std::size_t equations) override {
    for (std::size_t i = 0; i < equations; ++i) {
      phi_.set(i, of_lane(of, phi, static_cast<std::int32_t>(i)));
      scale_.set(i, of_lane(of, scale, static_cast<std::int32_t>(i)));
    }
    for (std::size_t e = 0; e < class_.entries.size(); ++e) change_.set(e, L::set(0));
  }

  bool hold(const Lane& of, const Block& block, const double* inverse) override {
    const std::size_t n = block.unknowns.size();
    const auto c = [&](std::size_t row, std::size_t column) HWY_ATTR { return L::set(inverse[column * n + row]); };
    for (std::size_t r = 0; r < n; ++r) {
      L sum = L::set(0), rounding = L::set(0);
      for (std::size_t e = 0; e < n; ++e) {
        sum.add_product(c(r, e), phi_[idx(block.equations[e])]);
        rounding.add_product(abs(c(r, e)), scale_[idx(block.equations[e])]);
      }
      L defect = L::set(kDefectBetween) * abs(sum);
      defect.add_product(L::set(kRoundingOfBranch), rounding);
      defect_.set(r, defect);
      radius_.set(r, L::set(kDefectBetween) * defect);
    }
    constexpr unsigned kAll = (1U << kPostures) - 1;
    unsigned held = 0;
    for (int growth = 0; growth < kGrowths && held != kAll; ++growth) {
      find_moves(of, block);
      unsigned inside = kAll, finite = kAll;
      for (std::size_t r = 0; r < n; ++r) {
        L image = defect_[r];
        for (std::size_t e = 0; e < n; ++e) image.add_product(abs(c(r, e)), moves_[e]);
        const L radius = radius_[r];
        inside &= less_equal(image, radius).bits();
        finite &= less_equal(image, L::set(std::numeric_limits<double>::max())).bits();
        radius_.set(r, L::set(kRadiusGrowth) * max(image, radius));
      }
      if (((finite | held) & kAll) != kAll) return false;
      held |= inside;
    }
    return held == kAll;
  }

 private:
  // moves_ = (|change of J| + |Phi'' r|) r for the box of radius r: upper bounds, equation after equation of the block.
  void find_moves(const Lane& of, const Block& block) {
    const auto k = coefficients(of);
    for (std::size_t i = 0; i < idx(class_.registers()); ++i) register_change_.set(i, L::set(0));
    for (std::size_t j = 0; j < block.unknowns.size(); ++j) register_change_.set(idx(block.unknowns[j]), radius_[j]);
    const auto add = [&](const std::vector<GroupClass::Operand>& list, std::int32_t begin, std::int32_t end, L& sum)
                         HWY_ATTR {
                           for (std::int32_t i = begin; i < end; ++i) {
                             const GroupClass::Operand& o = list[idx(i)];
                             sum.add_product(abs(k(o.coefficient)), register_change_[idx(o.reg)]);
                           }
                         };
    for (const GroupClass::Form& f : class_.forms) {
      L sum = L::set(0);
      add(class_.operands, f.unknowns, f.end, sum);
      register_change_.set(idx(f.reg), sum);
    }
    for (std::size_t e = 0; e < block.equations.size(); ++e) moves_.set(e, L::set(0));
    for (const JacobianEntry& e : block.entries) {
      L change = change_[idx(e.nonzero)], move = moves_[idx(e.row)];
      const GroupClass::Range operands = class_.entries[idx(e.nonzero)];
      add(class_.entry_operands, operands.begin, operands.end, change);
      move.add_product(change, radius_[idx(e.column)]);
      moves_.set(idx(e.row), move);
    }
  }

  const GroupClass& class_;
  QuadraticEquations<L> equations_;
  Array phi_{idx(class_.n)}, scale_{idx(class_.n)}, defect_{idx(class_.n)}, radius_{idx(class_.n)},
      moves_{idx(class_.n)};
  Array change_{class_.entries.size()};             // of the Jacobian
  Array register_change_{idx(class_.registers())};  // in the box
};

BoxTest* make(const GroupClass& group_class) { return new BoxTestOf(group_class); }

}  // namespace
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace assur {

HWY_EXPORT(make);

std::unique_ptr<BoxTest> make_box_test(const GroupClass& group_class) {
  return std::unique_ptr<BoxTest>(HWY_DYNAMIC_DISPATCH(make)(group_class));
}

}  // namespace assur
#endif
