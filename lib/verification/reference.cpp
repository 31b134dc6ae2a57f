// The forward error of a trajectory against the motion in quad precision.
//
// For each named output (a point with all its components) and each derivative: the largest |x - x_ref| of all times,
// divided by the largest |x_ref|, both in the maximum norm. The divisor is at least one internal unit (lengths: the
// characteristic length; angles: 1 rad), for rates times w / 2 pi, where w is the fastest rate of the driven
// coordinates in the run, and for accelerations times w^2 / 4 pi^2; the largest acceleration of a driven coordinate
// replaces w^2 if it is larger. For the acceleration of an angle it is also at least the square of the largest rate of
// the angle, if that is an output.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "assur/simulator.hpp"
#include "equations/outputs.hpp"
#include "numbers.hpp"
#include "outputs/output_program.hpp"
#include "verification/reference_motion.hpp"

namespace assur {
namespace {

constexpr double kSameMotion = 1e-3;  // a larger difference means that the two motions are on different branches
constexpr int kPieces = 16;           // parts of a step that the reference repeats

// The larger of both; NaN once it was NaN.
void raise(double& worst, double value) {
  if (!std::isnan(worst) && !(value <= worst)) worst = value;
}

// Jets of an output's components in SI units.
std::vector<Jet<Quad>> evaluate(const ReferenceMotion& motion, const Output& output) {
  const System& s = motion.system();
  std::vector<Jet<Quad>> out;
  for (const OutputPart& part : output.parts()) {
    Jet<Quad> forms[9];
    for (std::size_t f = 0; f < part.forms.size(); ++f) {
      const auto of = [&](std::size_t d) { return form_value<Quad>(s, part.forms[f], motion.state().q[d]); };
      forms[f] = {of(0), of(1), of(2)};
    }
    out.push_back(evaluate_measure<Quad>(part.kind, {forms, 9}, s.dimension) * Quad(s.unit(part.dimension)));
  }
  return out;
}

bool is_signed_angle(const OutputPart& part) {
  return part.kind == MeasureForms::Kind::absolute_angle || part.kind == MeasureForms::Kind::signed_angle;
}

class Comparison {
 public:
  Comparison(const Prepared& prepared, const Trajectory& trajectory) : trajectory_(trajectory), motion_(prepared) {
    std::vector<std::string> columns;
    std::map<std::pair<std::string_view, std::size_t>, std::size_t> column_of;  // of measures, for sums
    for (const Output& o : wanted_outputs(motion_.system())) {
      std::size_t next = columns.size();
      append_columns(o, columns);
      outputs_.emplace_back().output = o;
      for (std::size_t d = 0; d < 3; ++d) {
        if (!o.wanted[d]) continue;
        for (std::size_t i = 0; o.sum != nullptr && i < o.sum->terms.size(); ++i) {
          const auto& [measure, factor] = o.sum->terms[i];
          const std::string& name = motion_.system().measures[static_cast<std::size_t>(measure)].name;
          outputs_.back().terms[d].emplace_back(column_of.at({name, d}), factor);
        }
        if (o.component < 0) column_of[{o.name, d}] = next;
        next += o.part_count;
      }
    }
    row_.resize(columns.size());
    if (columns != trajectory.columns()) {
      throw Error(Error::Kind::input,
                  "the columns of the trajectory are not those of the scene: compare it with the scene that it was "
                  "computed from");
    }
    if (trajectory.rows() == 0) throw Error(Error::Kind::input, "the trajectory has no rows to compare");
  }

  ForwardError run() {
    for (std::size_t k = 0; k < trajectory_.rows(); ++k) {
      follow(k);
      for (std::size_t d = 0; d < 3; ++d) raise(scale_[d], motion_.scale(static_cast<int>(d)));
      for (Compared& o : outputs_) {
        for (std::size_t d = 0; d < 3; ++d) {
          raise(o.figures[d].difference, o.now[d].difference);
          raise(o.figures[d].size, o.now[d].size);
        }
      }
    }
    scale_[1] /= kTurn;
    scale_[2] /= kTurn * kTurn;
    ForwardError worst;
    double* const of[3] = {&worst.position, &worst.velocity, &worst.acceleration};
    for (const Compared& o : outputs_) {
      const double unit = motion_.system().unit(o.output.parts().front().dimension);
      for (std::size_t d = 0; d < 3; ++d) {
        if (!o.output.wanted[d]) continue;
        const double difference = o.figures[d].difference;
        double size = std::max(o.figures[d].size, scale_[d] * unit);
        // The direction that turns has an acceleration at least as large as the square of the rate.
        if (d == 2 && is_angle(o.output.parts().front().kind))
          size = std::max(size, o.figures[1].size * o.figures[1].size);
        const double error = difference != 0 ? difference / size : 0;
        *of[d] = std::fmax(*of[d], std::isnan(error) ? kInfinity : error);
      }
    }
    return worst;
  }

 private:
  struct Figure {
    double difference = 0, size = 0;  // |x - x_ref|, |x_ref|; 0 if not wanted
  };
  struct Compared {
    Output output;
    std::vector<std::pair<std::size_t, double>> terms[3];  // of a sum: columns and factors
    Figure figures[3];                                     // the worst of the run
    Figure now[3];
  };

  // Moves the reference to row k. If the two motions part, it repeats the step in smaller ones, because the reference
  // may have left the branch. It does so once for each parting.
  void follow(std::size_t k) {
    const ReferenceMotion::State before = motion_.state();
    motion_.advance(trajectory_.times()[k]);
    const bool apart = !compare(k);
    if (apart && !apart_) {
      motion_.restore(before);
      motion_.advance(trajectory_.times()[k], kPieces);
      apart_ = !compare(k);
    } else {
      apart_ = apart;
    }
  }

  // Fills `now`; true if the trajectory shows the same motion.
  bool compare(std::size_t k) {
    bool same = true;
    std::size_t column = 0;
    for (Compared& o : outputs_) {
      const std::vector<Jet<Quad>> jets = evaluate(motion_, o.output);
      const double unit = motion_.system().unit(o.output.parts().front().dimension);
      for (std::size_t d = 0; d < 3; ++d) {
        o.now[d] = {};
        if (!o.output.wanted[d]) continue;
        for (std::size_t i = 0; i < jets.size(); ++i, ++column) {
          const Quad x = trajectory_(k, column);
          Quad reference = d == 0 ? jets[i].value : d == 1 ? jets[i].rate : jets[i].acceleration;
          if (d == 0 && is_signed_angle(o.output.parts()[i])) reference += turns(x - reference);
          if (o.output.sum != nullptr) reference = d == 0 ? o.output.sum->constant.value() : 0;
          for (const auto& [term, factor] : o.terms[d]) reference += Quad(factor) * row_[term];
          row_[column] = reference;
          if (d > 0 && std::isnan(trajectory_(k, column))) continue;  // at a kink there is no derivative
          raise(o.now[d].difference, static_cast<double>(abs(x - reference)));
          raise(o.now[d].size, static_cast<double>(abs(reference)));
        }
        const double least = motion_.scale(static_cast<int>(d)) * unit;
        same = same && o.now[d].difference <= kSameMotion * std::max(o.now[d].size, least);
      }
    }
    return same;
  }

  // The multiple of 2 pi nearest to an angle: trajectories may count turns differently.
  static Quad turns(const Quad& angle) {
    static const Quad kTurn = 2 * acos(Quad(-1));
    return kTurn * std::round(static_cast<double>(angle) / (2 * std::numbers::pi));
  }

  const Trajectory& trajectory_;
  ReferenceMotion motion_;
  std::vector<Compared> outputs_;
  std::vector<Quad> row_;  // of the reference
  double scale_[3] = {};
  bool apart_ = false;
};

}  // namespace

ForwardError forward_error(const Prepared& prepared, const Trajectory& trajectory) {
  if (prepared.scene() == nullptr) {
    throw Error(Error::Kind::input, "a loaded plan has no scene, which a reference needs: prepare the scene instead");
  }
  return Comparison(prepared, trajectory).run();
}

}  // namespace assur
