#include "check/yardstick.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <string_view>
#include <utility>

#include "numbers.hpp"
#include "plan/preparation.hpp"

namespace assur::check {
namespace {

constexpr long double kSameMotion = 1e-3L;  // larger differences mean different branches
constexpr long double kUnknown = std::numeric_limits<long double>::quiet_NaN();

bool is_signed_angle(const OutputPart& part) {
  return part.kind == MeasureForms::Kind::absolute_angle || part.kind == MeasureForms::Kind::signed_angle;
}

class KnownMotion final : public TrueMotion {
 public:
  KnownMotion(const Prepared& prepared, ClosedForm closed_form)
      : outputs_(wanted_outputs(*preparation(prepared).structure->system)), closed_form_(std::move(closed_form)) {}

  std::vector<long double> row(std::size_t, double t) override {
    std::vector<long double> out;
    for (const Output& o : outputs_) {
      const auto jets = closed_form_(std::string(o.name), t);
      for (const int d : {0, 1, 2}) {
        if (!o.wanted[d]) continue;
        for (std::size_t i = 0; i < o.part_count; ++i) {
          const std::size_t component = o.component < 0 ? i : static_cast<std::size_t>(o.component);
          const LongJet jet = jets ? (*jets)[component] : LongJet{kUnknown, kUnknown, kUnknown};
          out.push_back(d == 0 ? jet.value : d == 1 ? jet.rate : jet.acceleration);
          if (jets && is_signed_angle(o.all_parts[i])) see(jet);
        }
      }
    }
    return out;
  }
  [[nodiscard]] double scale(int derivative) const override { return scale_[derivative]; }

 private:
  void see(const LongJet& angle) {
    constexpr long double kTurn = 2 * std::numbers::pi_v<long double>;
    const long double rate = std::abs(angle.rate) / kTurn, acceleration = std::abs(angle.acceleration) / kTurn / kTurn;
    scale_[1] = std::max(scale_[1], static_cast<double>(rate));
    scale_[2] = std::max({scale_[2], static_cast<double>(acceleration), static_cast<double>(rate * rate)});
  }

  std::vector<Output> outputs_;
  ClosedForm closed_form_;
  double scale_[3] = {1, 0, 0};
};

class AgreedMotion final : public TrueMotion {
 public:
  explicit AgreedMotion(const Trajectory& trajectory) : trajectory_(trajectory) {}
  std::vector<long double> row(std::size_t k, double t) override {
    if (k >= trajectory_.rows() || trajectory_.times()[k] != t) {
      throw Error(Error::Kind::numerical, "the first strategy stopped earlier");
    }
    return {trajectory_.row(k).begin(), trajectory_.row(k).end()};
  }

 private:
  Trajectory trajectory_;
};

}  // namespace

std::unique_ptr<TrueMotion> known_motion(const Prepared& prepared, ClosedForm closed_form) {
  return std::make_unique<KnownMotion>(prepared, std::move(closed_form));
}

std::unique_ptr<TrueMotion> agreed_motion(const Trajectory& trajectory) {
  return std::make_unique<AgreedMotion>(trajectory);
}

Yardstick::Yardstick(const Prepared& prepared, std::unique_ptr<TrueMotion> motion)
    : structure_(preparation(prepared).structure), motion_(std::move(motion)) {
  std::size_t column = 0;
  std::map<std::string_view, std::size_t> angle;
  for (const Output& o : wanted_outputs(*structure_->system)) {
    for (const int d : {0, 1, 2}) {
      if (!o.wanted[d]) continue;
      const OutputPart& part = o.all_parts[0];
      items_.push_back({column, o.part_count, d, structure_->system->unit(part.dimension),
                        d == 0 && o.part_count == 1 && is_signed_angle(part)});
      if (items_.back().angle) angle[o.name] = items_.size() - 1;
      for (std::size_t i = 0; d == 0 && o.sum != nullptr && i < o.sum->terms.size(); ++i) {
        const auto& [measure, factor] = o.sum->terms[i];
        const auto at = angle.find(structure_->system->measures[static_cast<std::size_t>(measure)].name);
        if (at != angle.end()) items_.back().angles.emplace_back(at->second, factor);
      }
      column += o.part_count;
    }
  }
}

long double Yardstick::turns(const Item& item, const Trajectory& trajectory, std::size_t row) const {
  constexpr long double kTurn = 2 * std::numbers::pi_v<long double>;
  if (row < item.turns_known) return 0;
  const long double difference = trajectory(row, item.first) - rows_[row][item.first];
  return difference - std::remainder(difference, kTurn);
}

Yardstick::Figure Yardstick::compare(const Item& item, const Trajectory& trajectory, std::size_t row) const {
  Figure figure;
  for (std::size_t i = item.first; i < item.first + item.count; ++i) {
    const long double is = rows_[row][i];
    if (std::isnan(is)) continue;
    long double difference = trajectory(row, i) - is;
    if (item.angle) difference -= turns(item, trajectory, row);
    for (const auto& [angle, factor] : item.angles) difference -= factor * turns(items_[angle], trajectory, row);
    difference = std::abs(difference);
    if (!(difference <= figure.difference)) figure.difference = std::isnan(difference) ? kInfinity : difference;
    figure.size = std::max(figure.size, std::abs(is));
  }
  return figure;
}

bool Yardstick::is_far(const Trajectory& trajectory, std::size_t row) const {
  return std::any_of(items_.begin(), items_.end(), [&](const Item& item) {
    const Figure f = compare(item, trajectory, row);
    const long double least = motion_->scale(item.derivative) * item.unit;
    return f.difference > kSameMotion * std::max(f.size, least);
  });
}

void Yardstick::add_row(const Trajectory& trajectory) {
  if (lost_) throw Error(*lost_);
  const std::size_t k = rows_.size();
  const double t = trajectory.times()[k];
  try {
    rows_.push_back(motion_->row(k, t));
    for (Item& item : items_) {
      if (item.angle && !motion_->knows_turns(item.first)) item.turns_known = std::min(item.turns_known, k);
    }
    // If the two differ, the yardstick may have taken the wrong branch: repeat the row. If they still differ, it has
    // not.
    if (apart_ || !is_far(trajectory, k)) return;
    rows_[k] = motion_->row_again(k, t);
    apart_ = is_far(trajectory, k);
  } catch (const Error& error) {
    rows_.resize(k);
    lost_ = error;
    throw;
  }
}

double Yardstick::forward_error(const Trajectory& trajectory, std::size_t rows, const Counts& counts) {
  std::vector<Figure> worst(items_.size());
  bool anything = false;
  for (std::size_t k = 0; k < std::min(rows, trajectory.rows()); ++k) {
    if (k == rows_.size()) add_row(trajectory);
    for (std::size_t i = 0; i < items_.size(); ++i) {
      const Figure f = compare(items_[i], trajectory, k);
      if (!counts || counts(k)) worst[i].difference = std::max(worst[i].difference, f.difference);
      worst[i].size = std::max(worst[i].size, f.size);
      anything = anything || !std::isnan(rows_[k][items_[i].first]);
    }
  }
  if (!anything) return rows == 0 || items_.empty() ? 0 : kInfinity;
  long double error = 0;
  for (std::size_t i = 0; i < items_.size(); ++i) {
    if (worst[i].difference == 0) continue;
    const long double least = motion_->scale(items_[i].derivative) * items_[i].unit;
    error = std::max(error, worst[i].difference / std::max(worst[i].size, least));
  }
  return static_cast<double>(error);
}

}  // namespace assur::check
