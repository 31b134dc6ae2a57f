// Checks the derivatives that functions of the program (callbacks and laws) return. They are compared with differences
// of the functions at several distances. The scatter between the distances, and second differences, give the error of
// each difference. Correct derivatives of stiff or noisy functions, or near a kink or an end, are therefore not
// reported. Nothing here throws: where a function throws near the posture, it is treated as undefined.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "equations/system.hpp"

namespace assur {

// A derivative that differences contradict.
struct Contradiction {
  enum class Of : std::uint8_t { value, rate, acceleration, jacobian, curvature };
  Of of = Of::value;
  Index row = 0, argument = 0;  // of a callback
  double time = 0;              // of a law
  double given = 0, found = 0;  // SI units; Of::value: the first and the second answer
  double uncertainty = 0;       // of `found`
  double excess = 0;            // the difference of both, relative to the tolerated one
};

// Differences of `rows` functions of one variable, from far to near.
class Differences {
 public:
  explicit Differences(std::size_t rows);

  // at(h, values) gives all rows at a signed distance h; NaN where they are not defined.
  template <class At>
  void measure(double longest, double shortest, At&& at) {
    levels_ = 0;
    at(0.0, middle_.data());
    for (double h = longest; h >= shortest && levels_ < kLevels; h /= kRatio) {
      at(h, after_.data());
      at(-h, before_.data());
      add_level(h);
    }
  }

  struct Verdict {
    bool contradicted = false;
    double found = 0, uncertainty = 0, excess = 0;
  };
  // Judges a given derivative. tolerance: relative to the derivative; floor: absolute error that is tolerated in
  // addition; noise: least error of the values of the function.
  [[nodiscard]] Verdict judge(std::size_t row, double given, double tolerance, double floor, double noise) const;

 private:
  static constexpr std::size_t kLevels = 12;
  static constexpr double kRatio = 4;
  void add_level(double h);
  [[nodiscard]] double slope(std::size_t level, std::size_t row) const { return slope_[level * rows_ + row]; }

  std::size_t rows_;
  std::size_t levels_ = 0;
  double distance_[kLevels] = {};
  std::vector<double> slope_, second_;  // levels x rows: central difference; f+ - 2 f0 + f-
  // rows: largest |f|; a power of two that divides all changes; the smallest change; 1 if a change is 0
  std::vector<double> size_, quantum_, least_change_;
  std::vector<std::uint8_t> still_;
  std::vector<double> middle_, before_, after_;
};

// Checks one callback at a posture with rates, which the owner sets.
class CallbackCheck {
 public:
  explicit CallbackCheck(const CallbackBlock& block);

  std::vector<double> x, rate;      // arguments, SI units
  std::vector<std::uint8_t> moves;  // 0: a constant, whose derivatives are not checked

  // Quick test along one direction with random signs, which `seed` draws: true if find() is needed. Three calls, with
  // `curvature` six.
  [[nodiscard]] bool doubtful(bool curvature, std::uint64_t seed);
  // The entry with the largest contradiction, if there is one. Some 25 calls for each argument.
  [[nodiscard]] std::optional<Contradiction> find(bool curvature);

 private:
  void residual(const std::vector<double>& at, double* phi) const;
  void jacobian(const std::vector<double>& at, double* j) const;
  [[nodiscard]] double tolerance() const { return block_.callback->tolerance; }
  [[nodiscard]] double largest_entry(std::size_t row) const;
  [[nodiscard]] double rounding(std::size_t row) const;
  [[nodiscard]] double shortest() const;
  [[nodiscard]] double time_to_move() const;
  void turn(const std::vector<double>& at, double* out);
  [[nodiscard]] bool doubtful_jacobian(std::uint64_t seed);
  [[nodiscard]] bool doubtful_curvature();
  void find_in_jacobian(std::optional<Contradiction>& worst);
  void find_in_curvature(std::optional<Contradiction>& worst);

  const CallbackBlock& block_;
  std::size_t m_, r_;
  Differences differences_;
  std::vector<double> given_, other_;  // r x m
  std::vector<double> moved_, direction_;
  std::vector<double> before_, after_, curvature_;  // r
};

// Checks the function of a law within a step of time. unit: SI value of an internal unit of the law; derivatives:
// number of derivatives to check.
class LawCheck {
 public:
  LawCheck() : differences_(2) {}

  // Quick test: true if find() is needed. Four calls.
  [[nodiscard]] static bool doubtful(const Law::Function& law, double from, double to, double unit, int derivatives);
  // The contradiction, if there is one. Some 25 calls.
  [[nodiscard]] std::optional<Contradiction> find(const Law::Function& law, double from, double to, double unit,
                                                  int derivatives);

 private:
  Differences differences_;
};

// A check of a callback of the system; it knows which arguments are constants.
[[nodiscard]] CallbackCheck check_of(const System& s, const CallbackBlock& block);

// SI value of an internal unit of a driver's k-th law.
[[nodiscard]] double law_unit(const System& s, const DriverInput& input, std::size_t k);

// Highest derivative that an output shows.
[[nodiscard]] int wanted_derivatives(const System& s);

// use(index into System::inputs, k, function) for every function among the parts of its k-th law.
template <class Use>
void for_each_function(const System& s, const Use& use) {
  for (std::size_t i = 0; i < s.inputs.size(); ++i) {
    for (std::size_t k = 0; k < s.inputs[i].laws.size(); ++k) {
      for (const Law::Part& part : s.inputs[i].laws[k].parts()) {
        if (const auto* function = std::get_if<Law::Function>(&part)) use(i, k, *function);
      }
    }
  }
}

// "jacobian[row 0, P.x] is 2.002, but differences of the residual give 2 (within 1e-9)"; of a law without a callback.
[[nodiscard]] std::string describe(const Contradiction& found, const Callback* callback);

// Checks every function of the scene at a posture (all coordinates) and between two times; returns one finding for each
// contradiction. Curvatures are not checked, because they need rates.
[[nodiscard]] std::vector<Diagnostic> contradictions(const System& s, const std::vector<double>& q, double from,
                                                     double to);

}  // namespace assur
