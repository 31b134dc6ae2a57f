#include "check/trial.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <sstream>
#include <variant>

#include "assur/simulator.hpp"
#include "check/doubt.hpp"
#include "mechanisms/plain_motion.hpp"

namespace assur::check {
namespace {

using mechanisms::PlainEquations;
using mechanisms::PlainMotion;
using mechanisms::PlainRows;
using mechanisms::RandomMechanism;
using mechanisms::Real;
using mechanisms::TimeJet;
using Verdict = Trial::Verdict;
constexpr int kMoreCare = 8;
constexpr double kSingular = 1e5;  // condition above which a posture is treated as singular
constexpr double kClean = 1e-6;    // accuracy that a clean status promises by default

// names.size() if it is not among them.
std::size_t place_in(const std::vector<std::string>& names, const std::string& name) {
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

std::string number(double x) {
  std::ostringstream out;
  out.precision(6);
  out << x;
  return out.str();
}

// Compares rows with the plain motion; errors are defined like ForwardError.
class Comparison {
 public:
  Comparison(PlainMotion& motion, const std::vector<std::string>& columns)
      : rows_(motion, columns), length_(motion.equations().length()), offset_(columns.size()) {}

  // Adds one row; `first`: the whole turns of angles are taken from this row.
  void add(std::span<const double> row, bool clean, double time, bool first) {
    constexpr Real kTurn = mechanisms::kTwoPi;
    const std::vector<Real> truth = rows_.now();
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const PlainEquations::Column& c = rows_.column(i);
      if (!c.known) continue;
      Real is = truth[i];
      if (rows_.is_angle(i)) {
        if (first) offset_[i] = std::round((row[i] - is) / kTurn) * kTurn;
        is += offset_[i];
        if (!rows_.knows_turns(i)) is += std::round((row[i] - is) / kTurn) * kTurn;
      }
      Figure& f = figures_[std::string(c.output) + "'" + std::to_string(c.derivative)];
      f.derivative = c.derivative, f.length = c.length;
      if (std::isnan(row[i]) || std::isnan(is)) continue;  // at 0 and pi, an unsigned angle has no rate
      f.size = std::max(f.size, std::abs(is));
      f.difference = std::max(f.difference, std::abs(row[i] - is));
      if (!clean) continue;
      if (std::abs(row[i] - is) > f.clean) f.clean = std::abs(row[i] - is), f.when = time;
    }
  }

  struct Worst {
    double error[3] = {0, 0, 0};
    std::string where[3];  // the outputs with these errors
    double clean = 0;      // largest error of rows with a clean status
    std::string output;
    double when = 0;
  };
  [[nodiscard]] Worst worst() const {
    Worst w;
    for (const auto& [name, f] : figures_) {
      const double least = (f.length ? length_ : 1) * rows_.scale(f.derivative);
      const Real size = std::max(f.size, Real(least));
      if (f.difference > 0 && double(f.difference / size) > w.error[f.derivative]) {
        w.error[f.derivative] = double(f.difference / size), w.where[f.derivative] = name;
      }
      if (f.clean > 0 && double(f.clean / size) > w.clean) {
        w.clean = double(f.clean / size), w.output = name, w.when = f.when;
      }
    }
    return w;
  }

 private:
  struct Figure {
    Real size = 0, difference = 0, clean = 0;
    double when = 0;
    int derivative = 0;
    bool length = false;
  };
  PlainRows rows_;
  double length_;
  std::vector<Real> offset_;
  std::map<std::string, Figure> figures_;
};

class Trying {
 public:
  Trying(const RandomMechanism& m, int care) : m_(m), care_(care), scene_(m.scene()), motion_(scene_, care) {}

  Trial take() {
    if (!begin()) return trial_;
    if (m_.commands.empty()) {
      run();
    } else {
      control();
    }
    return trial_;
  }

 private:
  Trial& end(Verdict verdict, std::string what, double time = 0) {
    trial_.verdict = verdict, trial_.what = std::move(what), trial_.time = time;
    return trial_;
  }

  PrepareOptions how() const {
    PrepareOptions how = m_.how;
    if (!m_.commands.empty()) how.controlled = m_.controlled;
    return how;
  }

  [[nodiscard]] bool starts_from(const std::string& json) const {
    try {
      const Simulator simulator(prepare(parse_scene(json, m_.family, m_.tables), how()));
      return true;
    } catch (const Error&) {
      return false;
    }
  }

  bool begin() {
    try {
      simulator_.emplace(prepare(scene_, how()));
    } catch (const Error& error) {
      // A guess may be too rough; the exact posture must be accepted.
      end(m_.rough > 0 && starts_from(m_.exact) ? Verdict::not_assembled : Verdict::refused, error.what());
      return false;
    }
    const std::vector<double> row(simulator_->outputs().begin(), simulator_->outputs().end());
    double figure = 0;
    const auto start =
        motion_.start(simulator_->columns(), row, laws_at(motion_.equations(), scene_.time().start), figure);
    if (start == PlainMotion::Start::singular) {
      end(Verdict::undecided, "the start posture is singular");
      return false;
    }
    if (start != PlainMotion::Start::right) {
      end(Verdict::wrong_start, std::string(start == PlainMotion::Start::off_law ? "the angle of a driver is wrong by "
                                                                                 : "an equation is violated by ") +
                                    number(figure));
      return false;
    }
    comparison_.emplace(motion_, simulator_->columns());
    return true;
  }

  bool settle(const std::vector<TimeJet<Real>>& laws) {
    const bool good = motion_.settle(laws);
    trial_.condition = std::max(trial_.condition, motion_.condition());
    return good;
  }

  void run() {
    const Trajectory trajectory = simulator_->run();
    const Report& report = simulator_->report();
    const auto& times = trajectory.times();
    if (!times.empty()) comparison_->add(trajectory.row(0), is_clean(report, times[0]), times[0], true);
    Real lost = HUGE_VALL;
    std::size_t k = 1;
    for (; k < times.size(); ++k) {
      const Real t0 = times[k - 1], t1 = times[k];
      const Real came = motion_.advance(t0, t1);
      if (came < 1) {
        lost = t0 + came * (t1 - t0);
        break;
      }
      if (!settle(laws_at(motion_.equations(), t1))) {
        lost = t1;
        break;
      }
      comparison_->add(trajectory.row(k), is_clean(report, times[k]), times[k], false);
      ++trial_.rows;
    }
    judge(report);
    if (trial_.is_fault()) return;
    const double reached = report.reached;
    if (lost < HUGE_VALL) {
      for (const Event& e : report.events) {
        if (doubts_branch(e) && e.time <= lost + 0.02L * (times[1] - times[0]))
          return void(end(Verdict::stopped_rightly, "an event at the singularity"));
      }
      end(Verdict::undecided,
          "the plain motion ends at t = " + number(double(lost)) + ", the run continued to " + number(reached));
      return;
    }
    if (report.status.arrived()) return;
    // The run stopped: does the motion continue?
    const TimeGrid& grid = scene_.time();
    const Real t0 = times.back(), t1 = t0 + static_cast<Real>(grid.step);
    if (report.status.code == Code::out_of_range) return;
    if (report.status.code == Code::actuator_zero && reaches_zero(static_cast<double>(t1))) {
      return void(end(Verdict::stopped_rightly, "the length of an actuator is not positive at the next time"));
    }
    const Real came = motion_.advance(t0, t1);
    const double ends = double(t0 + came * (t1 - t0));
    if (came < 1) {
      const bool there = std::abs(ends - reached) <= 0.02 * grid.step || ends <= reached;
      end(there ? Verdict::stopped_rightly : Verdict::refused,
          "the motion ends at t = " + number(ends) + ", the run stopped at " + number(reached) + " as " +
              std::string(name(report.status.code)),
          reached);
    } else {
      end(Verdict::refused,
          "stopped at t = " + number(reached) + " as " + std::string(name(report.status.code)) +
              ", but the motion continues; condition " + number(trial_.condition),
          reached);
    }
    if (trial_.verdict != Verdict::refused) return;
    try {
      Simulator again(
          prepare(scene_.with_time({grid.start, grid.start + static_cast<double>(16 * grid.steps()) * (grid.step / 16),
                                    grid.step / 16}),
                  how()));
      (void)again.run();
      trial_.what += "; with smaller steps the run " + (again.report().reached > reached + 0.05 * grid.step
                                                            ? "continues to " + number(again.report().reached)
                                                            : std::string("stops there as well"));
    } catch (const Error& error) {
      trial_.what += std::string("; with smaller steps: ") + error.what();
    }
  }

  [[nodiscard]] bool reaches_zero(double t) const {
    return std::any_of(scene_.drivers().begin(), scene_.drivers().end(), [&](const Driver& d) {
      const auto* const distance = std::get_if<DrivenDistance>(&d.kind);
      return distance != nullptr && distance->law(t).value <= 0;
    });
  }

  static bool is_clean(const Report& report, double t) {
    return std::none_of(report.events.begin(), report.events.end(), [t](const Event& e) {
      // After any other event the branch is in doubt until the end.
      return e.kind == Code::inaccurate ? e.time <= t && t <= e.until : doubts_branch(e) && e.time <= t;
    });
  }

  void judge(const Report& report) {
    const Comparison::Worst w = comparison_->worst();
    for (std::size_t d = 0; d < 3; ++d) trial_.error[d] = w.error[d];
    trial_.estimated[0] = report.error.estimated_position;
    trial_.estimated[1] = report.error.estimated_velocity;
    trial_.estimated[2] = report.error.estimated_acceleration;
    const double limit = std::max(m_.how.accuracy, 0.0) > 0 ? std::max(m_.how.accuracy, 1e-12) : kClean;
    if (!(w.clean <= limit)) {
      end(Verdict::wrong,
          w.output + " has the error " + number(w.clean) + " at t = " + number(w.when) +
              " with a clean status (required: " + number(limit) + "), condition " + number(trial_.condition),
          w.when);
      return;
    }
    const bool doubted = std::any_of(report.events.begin(), report.events.end(),
                                     [](const Event& e) { return e.kind == Code::inaccurate; });
    end(doubted ? Verdict::doubted : Verdict::agrees, "worst: " + w.where[0] + " " + w.where[1] + " " + w.where[2]);
  }

  // The way of a driver that a program sets: a quintic from the previous value, rate and acceleration (after a failure,
  // at rest) to the value and rate of the command.
  struct Way {
    Real value, rate, curve;                        // value and its derivatives at its begin
    Real to, to_rate, begins, ends;                 // value and rate at its end; times of begin and end
    [[nodiscard]] TimeJet<Real> at(Real s) const {  // s: 0 to 1 over the step; derivatives by s
      const Real h = ends - begins, v = h * rate, a = h * h * curve, w = h * to_rate;
      const Real p = to - value - v - a / 2, q = w - v - a, r = -a;
      const Real c3 = 10 * p - 4 * q + r / 2, c4 = -15 * p + 7 * q - r, c5 = 6 * p - 3 * q + r / 2;
      const TimeJet<Real> u(s, 1, 0);
      return TimeJet<Real>(value) +
             u * (TimeJet<Real>(v) + u * (TimeJet<Real>(a / 2) +
                                          u * (TimeJet<Real>(c3) + u * (TimeJet<Real>(c4) + u * TimeJet<Real>(c5)))));
    }
  };

  // All laws over a step as functions of s; the commanded drivers follow their ways.
  std::vector<TimeJet<Real>> commanded(const std::vector<Way>& ways, Real t0, Real t1, Real s) const {
    const Real h = t1 - t0;
    std::vector<TimeJet<Real>> laws = laws_at(motion_.equations(), t0 + s * h);
    for (std::size_t i = 0; i < laws.size(); ++i) {
      const std::size_t j = place_in(m_.controlled, motion_.equations().law_names()[i]);
      laws[i] = j < ways.size() ? ways[j].at(s) : TimeJet<Real>(laws[i].value, h * laws[i].rate, h * h * laws[i].curve);
    }
    return laws;
  }

  // A rate for which the driver does not overshoot: 0 if it turns back, else the smaller of both slopes.
  [[nodiscard]] double rate_at(std::size_t k, std::size_t i, double before) const {
    if (!m_.with_rates || k + 1 >= m_.commands.size()) return 0;
    const double a = m_.commands[k][i] - before, b = m_.commands[k + 1][i] - m_.commands[k][i];
    return a * b <= 0 ? 0 : (std::abs(a) < std::abs(b) ? a : b) / scene_.time().step;
  }

  void control() {
    std::vector<Way> ways(m_.controlled.size());
    const auto at_start = laws_at(motion_.equations(), scene_.time().start);
    for (std::size_t j = 0; j < ways.size(); ++j) {  // before the first set() the drivers follow their laws
      const auto& law = at_start[place_in(motion_.equations().law_names(), m_.controlled[j])];
      ways[j].value = law.value, ways[j].rate = law.rate, ways[j].curve = law.curve;
    }
    comparison_->add(simulator_->outputs(), is_clean(simulator_->report(), simulator_->time()), simulator_->time(),
                     true);
    Real time = simulator_->time();
    int failures = 0;
    for (std::size_t k = 0; k < m_.commands.size(); ++k) {
      for (std::size_t j = 0; j < ways.size(); ++j) {
        const double rate = rate_at(k, j, static_cast<double>(ways[j].value));
        ways[j].to = m_.commands[k][j], ways[j].to_rate = rate;
        simulator_->set(m_.controlled[j], m_.commands[k][j], rate);
      }
      const Status status = simulator_->step();
      const Real next = status.arrived() ? Real(simulator_->time()) : time + Real(scene_.time().step);
      for (Way& w : ways) w.begins = time, w.ends = next;
      const auto follow = [&] { return motion_.advance([&](Real s) { return commanded(ways, time, next, s); }); };
      Real came = follow();
      if (status.arrived() && came < 1) {  // drivers start at rest if they would overshoot a limit
        for (Way& w : ways) w.rate = w.curve = 0;
        came = follow();
      }
      const std::string which = "command " + std::to_string(k) + " of " + std::to_string(m_.commands.size());
      if (!status.arrived()) {
        ++failures;
        for (Way& w : ways) w.rate = w.curve = 0;
        if (came < 1) continue;  // the failure is right; the posture before is kept
        if (status.code == Code::actuator_zero && commands_zero(k)) continue;
        judge(simulator_->report());
        if (!trial_.is_fault()) {
          end(Verdict::refused,
              which + " fails as " + std::string(name(status.code)) + " at " + number(simulator_->time()) +
                  ", but the motion continues; " + std::to_string(failures - 1) + " failed before; condition " +
                  number(trial_.condition),
              double(time));
        }
        return;
      }
      if (came < 1) {
        judge(simulator_->report());
        if (!trial_.is_fault() && !is_clean_now()) {
          end(Verdict::stopped_rightly, "an event at the singularity");
        } else if (!trial_.is_fault()) {
          end(failures > 0 || trial_.condition > kSingular ? Verdict::undecided : Verdict::wrong,
              which + " arrives, but the plain motion ends", double(next));
        }
        return;
      }
      std::vector<TimeJet<Real>> there = commanded(ways, time, next, 1);
      const Real h = next - time;
      for (TimeJet<Real>& l : there) l = {l.value, l.rate / h, l.curve / (h * h)};
      for (std::size_t j = 0; j < ways.size(); ++j) {  // exactly the values that were set
        there[place_in(motion_.equations().law_names(), m_.controlled[j])] = {ways[j].to, ways[j].to_rate, 0};
        ways[j].value = ways[j].to, ways[j].rate = ways[j].to_rate, ways[j].curve = 0;
      }
      if (!settle(there)) break;
      time = next;
      comparison_->add(simulator_->outputs(), status.ok(), double(time), false);
      ++trial_.rows;
      if (!is_clean_now()) break;  // an event reports that another branch may have been taken
    }
    judge(simulator_->report());
    if (!trial_.is_fault() && failures > 0)
      end(Verdict::stopped_rightly, std::to_string(failures) + " commands failed as expected");
  }

  [[nodiscard]] bool commands_zero(std::size_t k) const {
    return std::any_of(scene_.drivers().begin(), scene_.drivers().end(), [&](const Driver& d) {
      const std::size_t i = place_in(m_.controlled, d.name);
      return std::holds_alternative<DrivenDistance>(d.kind) && i < m_.controlled.size() && m_.commands[k][i] <= 0;
    });
  }

  // False if an event reports that another branch may have been taken.
  [[nodiscard]] bool is_clean_now() const {
    return std::none_of(simulator_->report().events.begin(), simulator_->report().events.end(),
                        [](const Event& e) { return e.kind == Code::change_point_passed; });
  }

  const RandomMechanism& m_;
  int care_;
  Scene scene_;
  PlainMotion motion_;
  std::optional<Simulator> simulator_;
  std::optional<Comparison> comparison_;
  Trial trial_;
};

}  // namespace

const char* name(Verdict verdict) {
  switch (verdict) {
    case Verdict::agrees:
      return "agrees";
    case Verdict::doubted:
      return "doubted";
    case Verdict::stopped_rightly:
      return "stopped rightly";
    case Verdict::undecided:
      return "undecided";
    case Verdict::not_assembled:
      return "not assembled";
    case Verdict::refused:
      return "refused";
    case Verdict::wrong_start:
      return "wrong start";
    case Verdict::wrong:
      return "wrong";
  }
  return "";
}

Trial try_out(const RandomMechanism& mechanism, int care) {
  Trial trial = Trying(mechanism, care).take();
  if ((!trial.is_fault() && trial.verdict != Verdict::undecided) || care >= kMoreCare) return trial;
  return Trying(mechanism, kMoreCare).take();
}

}  // namespace assur::check
