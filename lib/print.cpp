#include "assur/print.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>

#include "assur/strategy.hpp"
#include "decimal.hpp"
#include "status_text.hpp"

namespace assur {
namespace {

std::string number(double value) { return general(value, 6); }

std::string counted(std::size_t count, std::string_view noun) {
  return std::to_string(count) + " " + std::string(noun) + (count == 1 ? "" : "s");
}

std::string size_of(std::size_t rows, std::size_t columns, const std::vector<double>& times) {
  std::string text = counted(rows, "row") + " of " + counted(columns, "column");
  if (!times.empty()) text += ", t = " + general(times.front(), 10) + " ... " + general(times.back(), 10) + " s";
  return text;
}

// "position 1.2e-16, velocity 3.4e-16"; figures that were not measured are left out.
std::string figures_of(const std::optional<double> (&figures)[3]) {
  static constexpr std::string_view kNames[3] = {"position", "velocity", "acceleration"};
  std::string text;
  for (std::size_t d = 0; d < 3; ++d) {
    if (!figures[d] || std::isnan(*figures[d])) continue;
    text += (text.empty() ? "" : ", ") + std::string(kNames[d]) + " " + scientific(*figures[d], 1);
  }
  return text;
}

}  // namespace

std::ostream& operator<<(std::ostream& out, Code code) { return out << name(code); }

std::ostream& operator<<(std::ostream& out, const Status& status) {
  static constexpr std::string_view kPlaces[] = {"", "driver", "group", "lane", "member", "target", "limit"};
  std::string text = status.code == Code::ok ? "ok" : explained(status.code);
  if (!status.where.is(Place::Kind::none)) {
    text += ", " + std::string(kPlaces[static_cast<std::size_t>(status.where.kind)]) + " " +
            std::to_string(status.where.index);
  }
  if (status.figure != 0) text += ", figure " + number(status.figure);
  return out << text;
}

std::ostream& operator<<(std::ostream& out, const Event& event) {
  return out << time_of(event) + place_of(event) + ": " + explained(event.kind) +
                    (event.detail.empty() ? "" : ": " + event.detail);
}

std::ostream& operator<<(std::ostream& out, const Counters& c) {
  return out << std::to_string(c.steps) + " steps, " + std::to_string(c.substeps) + " substeps, " +
                    std::to_string(c.rejected) + " rejected; " + std::to_string(c.newton_iterations) +
                    " Newton iterations, " + std::to_string(c.factorizations) + " factorisations";
}

std::ostream& operator<<(std::ostream& out, const ErrorFigures& e) {
  const auto add = [](std::string& text, std::string_view what, const std::string& figures) {
    if (!figures.empty()) text += (text.empty() ? "" : "; ") + std::string(what) + ": " + figures;
  };
  std::string text;
  add(text, "residuals", figures_of({e.position, e.velocity, e.acceleration}));
  add(text, "estimated errors", figures_of({e.estimated_position, e.estimated_velocity, e.estimated_acceleration}));
  add(text, "certified radius", e.certified_radius ? scientific(*e.certified_radius, 1) : "");
  add(text, "errors", figures_of({e.forward_position, e.forward_velocity, e.forward_acceleration}));
  return out << (text.empty() ? "nothing was measured" : text);
}

std::ostream& operator<<(std::ostream& out, const ForwardError& e) {
  const std::string text = figures_of({e.position, e.velocity, e.acceleration});
  return out << (text.empty() ? "nothing was measured" : text);
}

std::ostream& operator<<(std::ostream& out, const GroupFigures& f) {
  return out << "group " + std::to_string(f.group) + ": residual " + scientific(f.residual, 1) + ", condition " +
                    scientific(f.condition, 1) + ", estimated error " + scientific(f.estimated_error, 1);
}

std::ostream& operator<<(std::ostream& out, const Certificate& c) {
  std::string text = "t = " + general(c.time, 10) + " s: ";
  if (c.why_not.empty()) {
    text += "the posture is within " + scientific(c.radius, 1) + " of the computed one, and the only one within " +
            scientific(c.uniqueness, 1);
  } else {
    text += "nothing is proven for group " + c.group + ": " + c.why_not;
  }
  return out << text;
}

std::ostream& operator<<(std::ostream& out, const Motion& m) {
  return out << number(m.value) + ", rate " + number(m.rate) + ", acceleration " + number(m.acceleration);
}

std::ostream& operator<<(std::ostream& out, const TimeGrid& grid) {
  return out << number(grid.start) + " to " + number(grid.end) + " s by " + number(grid.step) + " s";
}

std::ostream& operator<<(std::ostream& out, const ColumnSummary& s) {
  return out << "from " + number(s.minimum) + " (t = " + number(s.minimum_time) + " s) to " + number(s.maximum) +
                    " (t = " + number(s.maximum_time) + " s), mean " + number(s.mean) + ", last " + number(s.last);
}

std::ostream& operator<<(std::ostream& out, const Trajectory& t) {
  return out << size_of(t.rows(), t.columns().size(), t.times());
}

std::ostream& operator<<(std::ostream& out, const EnsembleTrajectory& t) {
  return out << counted(t.members(), "member") + " x " + size_of(t.times().size(), t.columns().size(), t.times());
}

std::ostream& operator<<(std::ostream& out, const Ensemble::Outcome& outcome) {
  if (!outcome.cannot.empty()) return out << "cannot start: " + outcome.cannot;
  return out << outcome.status << ", reached t = " << general(outcome.reached, 10) << " s";
}

std::ostream& operator<<(std::ostream& out, const Report& r) {
  out << r.status << ", reached t = " << general(r.reached, 10) << " s\n" << r.counters << '\n' << r.error << '\n';
  for (const Event& event : r.events) out << "event: " << event << '\n';
  if (r.dropped_events > 0) out << std::to_string(r.dropped_events) << " earlier events were dropped\n";
  for (const std::string& line : r.fallbacks) out << "not as planned: " << line << '\n';
  return out;
}

std::ostream& operator<<(std::ostream& out, const Plan& plan) {
  for (const Plan::Choice& choice : plan.choices) {
    out << "class " + std::to_string(choice.group_class) + ": " + to_string(plan.strategy(choice)) +
               (choice.reason.empty() ? "" : " (" + choice.reason + ")") + "\n";
  }
  return out;
}

std::ostream& operator<<(std::ostream& out, const OutputJacobian& j) {
  const auto widest = [](const std::vector<std::string>& names, std::size_t least) {
    for (const std::string& name : names) least = std::max(least, name.size());
    return least;
  };
  const auto right = [](const std::string& text, std::size_t width) {
    return std::string(width - std::min(width, text.size()), ' ') + text;
  };
  const std::size_t first = widest(j.outputs, 0), width = widest(j.drivers, 12) + 2;
  out << std::string(first, ' ');
  for (const std::string& driver : j.drivers) out << right(driver, width);
  out << '\n';
  for (std::size_t r = 0; r < j.outputs.size(); ++r) {
    out << j.outputs[r] << std::string(first - j.outputs[r].size(), ' ');
    for (std::size_t c = 0; c < j.drivers.size(); ++c) out << right(number(j(r, c)), width);
    out << '\n';
  }
  return out << "smallest singular value: " << number(j.smallest_singular_value) << '\n';
}

}  // namespace assur
