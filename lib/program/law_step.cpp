#include "program/law_step.hpp"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "evaluation/angles-inl.hpp"
#include "numbers.hpp"
#include "program/step_graph.hpp"
#include "scene/law_evaluate.hpp"

namespace assur {
namespace {

class LawWriter {
 public:
  explicit LawWriter(const LawOutline& of) : of_(of) {}

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
    for (const LawOutline::Tables& layer : block.tables) add_tables(layer, t, value, rate, acceleration);
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

  // An interval of a table, in order; behind the last one is a beginning that is never reached.
  enum Interval : std::uint8_t { kBegin, kEnd, kFirst, kLast, kFirstBend, kLastBend, kIntervalSize };

  // Adds law_detail::evaluate() of each lane's table, in internal units.
  void add_tables(const LawOutline::Tables& layer, const Value& time, Value& value, Value& rate, Value& acceleration) {
    const std::size_t w = static_cast<std::size_t>(of_.lanes);
    const auto lanes = [&](const auto& number) {
      std::vector<double> out(w);
      for (std::size_t l = 0; l < w; ++l) out[l] = number(layer.of[l]);
      return out;
    };
    std::size_t most = 0;
    const std::vector<double> begin = lanes([&](const Law::Spline* s) { return place(s, most); });
    const Value offset = row(begin);
    const Value is_there = row(lanes([](const Law::Spline* s) { return s != nullptr ? 1.0 : 0.0; }));
    const Value end = row(lanes([](const Law::Spline* s) { return s != nullptr ? double(s->time.size()) - 1 : 0.0; }));
    const auto limit = [&](bool is_upper) {
      return row(lanes([is_upper](const Law::Spline* s) {
        if (s == nullptr || s->periodic) return is_upper ? kInfinity : -kInfinity;
        return is_upper ? s->time.back() + law_detail::slack(*s) : s->time.front() - law_detail::slack(*s);
      }));
    };
    const Value least = limit(false), largest = limit(true);
    const Value t = wrapped(lanes, time);

    // The last beginning that is not after t: law_detail::interval().
    Value k = Value::set(0);
    const Value size = Value::set(kIntervalSize);
    const auto number = [&](const Value& interval, Interval which) {
      return graph_.pick({Memory::factors, 0, Reach::one}, offset + interval * size + Value::set(which));
    };
    std::size_t step = 1;
    while (step <= most) step *= 2;
    for (step /= 2; step > 0; step /= 2) {
      const Value further = k + Value::set(static_cast<double>(step));
      const Value next = if_at_most(further, end, further, end);
      k = if_at_most(number(next, kBegin), t, next, k);
    }
    const Value from = number(k, kBegin), to = number(k, kEnd), y0 = number(k, kFirst), y1 = number(k, kLast);
    const Value m0 = number(k, kFirstBend), m1 = number(k, kLastBend);
    const Value one = Value::set(1), three = Value::set(3), six = Value::set(6);
    const Value h = to - from, a = (to - t) / h, b = (t - from) / h;
    const Value unit = row(layer.unit);
    // A lane without a table adds -0, which changes no number, or 0 to a sum without terms.
    const auto add = [&](Value& sum, const Value& v) {
      const Value undefined = Value::set(kNan), none = Value::set(sum.is_constant() ? 0.0 : -0.0);
      const Value covered = if_at_most(least, time, if_at_most(time, largest, v, undefined), undefined);
      sum = sum + if_at_most(is_there, Value::set(0), none, covered * unit);
    };
    add(value, a * y0 + b * y1 - a * b * h * h / six * ((one + a) * m0 + (one + b) * m1));
    add(rate, (y1 - y0) / h + h / six * ((three * b * b - one) * m1 - (three * a * a - one) * m0));
    add(acceleration, a * m0 + b * m1);
  }
  // Appends the intervals of a table. most: the largest number of intervals
  [[nodiscard]] double place(const Law::Spline* table, std::size_t& most) {
    std::vector<double>& to = out_.numbers;
    const auto first = static_cast<double>(to.size());
    const std::size_t intervals = table != nullptr ? table->time.size() - 1 : 0;
    for (std::size_t k = 0; k < intervals; ++k) {
      const auto [left, right] = table->bends(k);
      to.insert(to.end(), {table->time[k], table->time[k + 1], table->value[k], table->value[k + 1], left, right});
    }
    to.insert(to.end(), {kInfinity, 0, 0, 0, 0, 0});
    most = std::max(most, intervals);
    return first;
  }
  // law_detail::wrap() in lanes of periodic tables.
  template <class Lanes>
  [[nodiscard]] Value wrapped(const Lanes& lanes, const Value& time) {
    const auto of_period = [&](const auto& number) {
      return row(lanes([&](const Law::Spline* s) {
        return s != nullptr && s->periodic ? number(s->time.front(), s->time.back()) : 1.0;
      }));
    };
    const Value first = of_period([](double begin, double) { return begin; });
    const Value period = of_period([](double begin, double end) { return end - begin; });
    const Value lost = of_period(law_detail::lost_period);
    const Value repeats = row(lanes([](const Law::Spline* s) { return s != nullptr && s->periodic ? 1.0 : 0.0; }));
    const Value turns = (time - first) / period, nearest = round(turns);
    const Value count = if_at_most(nearest, turns, nearest, nearest - Value::set(1));
    Value rest = time;
    rest.subtract_product(count, period);
    return if_at_most(repeats, Value::set(0), time, rest - count * lost);
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

LawStep law_step(const LawOutline& outline) { return LawWriter(outline).write(); }

}  // namespace assur
