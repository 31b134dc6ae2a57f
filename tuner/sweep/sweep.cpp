#include "sweep/sweep.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <utility>

#include "equations/outputs.hpp"
#include "numbers.hpp"
#include "output/format.hpp"
#include "runs/row_consumers.hpp"
#include "scene/names.hpp"
#include "structure/grouped_system.hpp"

namespace assur::sweep {
namespace {

constexpr std::size_t kRowsAtOnce = 1024;  // of a member

struct NamedFigure {
  std::string_view name;
  double (*of)(const ColumnSummary& column);
};
constexpr NamedFigure kFigures[] = {{"min", [](const ColumnSummary& c) { return c.minimum; }},
                                    {"max", [](const ColumnSummary& c) { return c.maximum; }},
                                    {"min_time", [](const ColumnSummary& c) { return c.minimum_time; }},
                                    {"max_time", [](const ColumnSummary& c) { return c.maximum_time; }},
                                    {"mean", [](const ColumnSummary& c) { return c.mean; }},
                                    {"last", [](const ColumnSummary& c) { return c.last; }},
                                    {"range", [](const ColumnSummary& c) { return c.range(); }}};

double figure_of(const ColumnSummary& column, std::string_view name) {
  for (const NamedFigure& figure : kFigures) {
    if (figure.name == name) return figure.of(column);
  }
  throw Error(Error::Kind::input, "no figure is called " + std::string(name));
}

// How often a limit was exceeded, or ended the motion.
double times_exceeded(const Ensemble::Outcome& outcome) {
  return static_cast<double>(std::count_if(outcome.events.begin(), outcome.events.end(), [](const Event& e) {
    return e.kind == Code::limit_exceeded || e.kind == Code::limit_reached;
  }));
}

std::string text_of(double number) { return std::isnan(number) ? "" : shortest(number); }

[[noreturn]] void refuse_line(const std::string& line) {
  throw Error(Error::Kind::input, "\"" + line.substr(0, 60) + "\" is not a row of this sweep");
}

double number_in(const std::string& text, const std::string& line) {
  if (text.empty()) return kNan;
  double number = 0;
  const auto [end, trouble] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (trouble != std::errc() || end != text.data() + text.size()) refuse_line(line);
  return number;
}

}  // namespace

std::vector<std::string> columns_of(const Scene& scene) { return column_names(*group_equations(scene).system); }

void check_point(const std::string& point, const Scene& scene, const std::vector<std::string>& columns) {
  if (scene.dimension() != 2) {
    throw Error(Error::Kind::input, {{"--trace", "compares paths in the plane; this scene is in space"}});
  }
  for (const char* coordinate : {".x", ".y"}) {
    if (std::find(columns.begin(), columns.end(), point + coordinate) != columns.end()) continue;
    throw Error(Error::Kind::input, {{"--trace", "\"" + point + "\" is not a point among the outputs of the scene"}});
  }
}

void check_target(const Trace& trace, const Scene& scene) {
  const auto points = static_cast<std::int64_t>(trace.target.size()), times = scene.time().steps() + 1;
  if ((trace.distance != "timed" && trace.distance != "fitted") || points == times) return;
  throw Error(Error::Kind::input,
              {{"--compare", "compares points at equal times: the target has " + output::counted(points, "point") +
                                 ", and the path " + std::to_string(times)}});
}

void check_same_times(const Scene& one, const Scene& other) {
  const TimeGrid a = one.time(), b = other.time();
  if (a.start == b.start && a.end == b.end && a.step == b.step) return;
  throw Error(Error::Kind::input,
              {{"--vary", "a parameter changes the time grid, which must be the same for all samples"}});
}

const std::vector<std::string>& figure_names() {
  static const std::vector<std::string> kNames = [] {
    std::vector<std::string> names;
    for (const NamedFigure& figure : kFigures) names.emplace_back(figure.name);
    return names;
  }();
  return kNames;
}

const std::vector<std::string>& distance_names() {
  static const std::vector<std::string> kNames = {"nearest", "timed", "fitted", "shape"};
  return kNames;
}

Sweep::Sweep(const DesignSpace& space, Scene scene, PrepareOptions how, std::vector<std::string> columns,
             std::vector<std::string> figures, std::optional<Trace> trace, StepSettings settings)
    : space_(space),
      scene_(std::move(scene)),
      how_(std::move(how)),
      columns_(std::move(columns)),
      figures_(std::move(figures)),
      trace_(std::move(trace)),
      settings_(std::move(settings)) {}

std::vector<double> Sweep::values_of(std::int64_t b) const {
  std::vector<double> values;
  for (std::int64_t k = b * kBlock; k < std::min((b + 1) * kBlock, space_.samples()); ++k) {
    const std::vector<double> point = space_.point(k);
    values.insert(values.end(), point.begin(), point.end());
  }
  return values;
}

Ensemble Sweep::make(std::vector<double> values) const {
  std::vector<std::string> names;
  for (const Range& r : space_.ranges()) names.push_back(r.name);
  return {scene_, std::move(names), std::move(values), how_, settings_};
}

std::vector<DesignSample> Sweep::block(std::int64_t b) {
  const std::vector<double> values = values_of(b);
  const std::size_t parameters = space_.ranges().size();
  std::vector<DesignSample> rows(values.size() / parameters);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto point = values.begin() + static_cast<std::ptrdiff_t>(i * parameters);
    rows[i].sample = b * kBlock + static_cast<std::int64_t>(i);
    rows[i].parameters.assign(point, point + static_cast<std::ptrdiff_t>(parameters));
    rows[i].status = DesignSample::kNotAssembled;
    rows[i].reached = kNan;
    rows[i].figures.assign(figures().size(), kNan);
  }
  const auto none_can_be_prepared = [](const Error& e) { return e.kind() != Error::Kind::environment; };
  try {
    if (!std::exchange(is_made_, true)) ensemble_.emplace(make(values_of(0)));
  } catch (const Error& e) {
    if (!none_can_be_prepared(e)) throw;
  }
  try {
    if (ensemble_) {
      ensemble_->bind(values);
      run(*ensemble_, rows);
    } else {
      Ensemble own = make(values);
      run(own, rows);
    }
  } catch (const Error& e) {
    if (ensemble_ || !none_can_be_prepared(e)) throw;
    for (DesignSample& row : rows) row.why = e.what();  // the first reason
  }
  return settings_.stop && settings_.stop() ? std::vector<DesignSample>() : rows;
}

void Sweep::run(Ensemble& ensemble, std::vector<DesignSample>& rows) {
  std::vector<ColumnSummary> summaries(rows.size() * columns_.size());
  std::vector<std::size_t> all(columns_.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  std::vector<RowSummary> consumers;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    consumers.emplace_back(all, std::span(summaries).subspan(i * columns_.size(), columns_.size()));
  }
  RowSelection selection{columns_};
  if (trace_) {
    selection.columns.insert(selection.columns.end(), {trace_->point + ".x", trace_->point + ".y"});
  } else {
    selection.block = kRowsAtOnce;
  }
  const auto sink = [&](const MemberRows& of) {
    const std::size_t width = selection.columns.size();
    for (std::size_t k = 0; k < of.times.size(); ++k) consumers[of.member].add_row(of.times[k], &of.values[k * width]);
    if (!trace_) return;
    std::vector<PlanePoint> path;
    for (std::size_t k = 0; k < of.times.size(); ++k) {
      const double* const end = &of.values[(k + 1) * width];
      path.push_back({end[-2], end[-1]});
    }
    rows[of.member].figures[0] = distance(path);
  };
  ensemble.stream(selection, sink, [&](std::int64_t, std::int64_t) { return settings_.stop && settings_.stop(); });
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Ensemble::Outcome& outcome = ensemble.outcomes()[i];
    rows[i].why = outcome.cannot;
    if (!outcome.cannot.empty()) continue;
    rows[i].status = name(outcome.status.code);
    rows[i].reached = outcome.reached;
    consumers[i].finish();
    std::size_t to = trace_ ? 1 : 0;
    if (trace_ && !rows[i].is_done()) rows[i].figures[0] = kNan;
    if (!scene_.limits().empty()) rows[i].figures[to++] = times_exceeded(outcome);
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      for (const std::string& figure : figures_) {
        rows[i].figures[to++] = figure_of(summaries[i * columns_.size() + c], figure);
      }
    }
  }
}

double Sweep::distance(std::span<const PlanePoint> path) const {
  if (trace_->distance == "nearest") return nearest_distance(path, trace_->target);
  if (trace_->distance == "shape") return shape_distance(path, trace_->target);
  if (path.size() != trace_->target.size()) return kNan;
  return trace_->distance == "timed" ? timed_distance(path, trace_->target) : fitted_distance(path, trace_->target);
}

std::vector<std::string> Sweep::figures() const {
  std::vector<std::string> names;
  if (trace_) names.push_back(trace_->point + ".distance");
  if (!scene_.limits().empty()) names.emplace_back("limits");
  for (const std::string& column : columns_) {
    for (const std::string& figure : figures_) names.push_back(std::string(column).append(".").append(figure));
  }
  return names;
}

std::string Sweep::header() const {
  std::string line = "sample";
  for (const Range& r : space_.ranges()) line += "," + r.name;
  line += ",status,reached";
  for (const std::string& figure : figures()) line += "," + figure;
  return line;
}

std::string Sweep::line_of(const DesignSample& row) {
  std::string line = std::to_string(row.sample);
  for (const double p : row.parameters) line += "," + text_of(p);
  line += "," + row.status + "," + text_of(row.reached);
  for (const double f : row.figures) line += "," + text_of(f);
  return line;
}

DesignSample Sweep::parse(const std::string& line) const {
  std::vector<std::string> cells(1);
  for (const char c : line) {
    if (c == ',') {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  const std::size_t parameters = space_.ranges().size(), figures = this->figures().size();
  if (cells.size() != 3 + parameters + figures) refuse_line(line);
  DesignSample row;
  const std::string& sample = cells[0];
  const auto [end, trouble] = std::from_chars(sample.data(), sample.data() + sample.size(), row.sample);
  if (trouble != std::errc() || end != sample.data() + sample.size()) refuse_line(line);
  std::size_t next = 1;
  for (std::size_t i = 0; i < parameters; ++i) row.parameters.push_back(number_in(cells[next++], line));
  row.status = cells[next++];
  row.reached = number_in(cells[next++], line);
  for (std::size_t i = 0; i < figures; ++i) row.figures.push_back(number_in(cells[next++], line));
  return row;
}

}  // namespace assur::sweep
