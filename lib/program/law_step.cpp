#include "program/law_step.hpp"

#include <algorithm>
#include <limits>

#include "program/graph.hpp"
#include "program/sine-inl.hpp"
#include "scene/law_evaluate.hpp"

namespace assur {
namespace {

class Writer {
 public:
  explicit Writer(const LawOutline& of) : of_(of) {}

  [[nodiscard]] LawStep write() {
    Value too_large = Value::set(0);
    for (std::size_t b = 0; b < of_.blocks.size(); ++b) too_large = too_large + write(of_.blocks[b], b);
    graph_.store({Memory::figures, 0}, too_large);
    out_.program.phases.push_back(graph_.phase());
    return std::move(out_);
  }

 private:
  // Positive where an angle is too large.
  [[nodiscard]] Value write(const LawOutline::Block& block, std::size_t number) {
    const Value t = graph_.load({Memory::settings, 0, Reach::one});
    Value value = row(block.base), rate = Value::set(0), acceleration = rate;
    for (const LawOutline::Harmonics& h : block.harmonics) {
      HWY_NAMESPACE::add_harmonic(t, Value::set(law_detail::two_pi<double>()), row(h.frequency), row(h.phase),
                                  row(h.amplitude), row(h.omega), value, rate, acceleration);
    }
    for (const LawOutline::Polynomials& p : block.polynomials) {
      Value of_value = Value::set(0), of_rate = of_value, half = of_value;  // law_detail::horner()
      for (std::size_t power = p.size(); power-- > 0;) {
        half = half * t + of_rate;
        of_rate = of_rate * t + of_value;
        of_value = of_value * t + row(p[power]);
      }
      value = value + of_value;
      rate = rate + of_rate;
      acceleration = acceleration + 2 * half;
    }
    const auto put = [&](Memory memory, const Value& v) {
      graph_.store({memory, static_cast<std::uint32_t>(number) * static_cast<std::uint32_t>(of_.lanes), Reach::from},
                   v);
    };
    put(Memory::laws, value);
    put(Memory::law_rates, rate);
    put(Memory::law_accelerations, acceleration);
    if (block.angles == 0) return Value::set(0);
    const auto [sine, cosine] = HWY_NAMESPACE::sin_cos_of(value);
    put(Memory::sines, sine);
    put(Memory::cosines, cosine);
    std::vector<double> largest(static_cast<std::size_t>(of_.lanes), std::numeric_limits<double>::max());
    std::fill_n(largest.begin(), block.angles, kLargestAngle);
    return if_at_most(abs(value), row(largest), Value::set(0), Value::set(1));
  }
  // One number for each lane.
  [[nodiscard]] Value row(const std::vector<double>& numbers) {
    const auto first = static_cast<std::uint32_t>(out_.numbers.size());
    out_.numbers.insert(out_.numbers.end(), numbers.begin(), numbers.end());
    return graph_.load({Memory::factors, first, Reach::from});
  }

  const LawOutline& of_;
  Graph graph_;
  LawStep out_;
};

}  // namespace

LawStep law_step(const LawOutline& outline) { return Writer(outline).write(); }

}  // namespace assur
