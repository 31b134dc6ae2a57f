#include "sweep/sweep.hpp"

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cmath>
#include <exception>
#include <optional>
#include <utility>

#include "numbers.hpp"
#include "parallel/team.hpp"
#include "scene/names.hpp"

namespace assur::sweep {
namespace {

double figure_of(const ColumnSummary& s, const std::string& name) {
  if (name == "min") return s.minimum;
  if (name == "max") return s.maximum;
  if (name == "min_time") return s.minimum_time;
  if (name == "max_time") return s.maximum_time;
  if (name == "mean") return s.mean;
  if (name == "last") return s.last;
  return s.range();
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

// The prepared samples, or why they cannot be prepared.
struct Attempts {
  std::vector<std::optional<Prepared>> prepared;
  std::vector<std::exception_ptr> errors;

  Prepared take(std::size_t i) {
    if (errors[i]) std::rethrow_exception(errors[i]);
    return *std::exchange(prepared[i], std::nullopt);
  }
};

}  // namespace

const std::vector<std::string>& figure_names() {
  static const std::vector<std::string> kNames = {"min", "max", "min_time", "max_time", "mean", "last", "range"};
  return kNames;
}

Sweep::Sweep(const DesignSpace& space, std::function<Prepared(const std::vector<double>&)> prepare,
             std::vector<std::string> columns, std::vector<std::string> figures, int threads, StepLimits limits)
    : space_(space),
      prepare_(std::move(prepare)),
      columns_(std::move(columns)),
      figures_(std::move(figures)),
      threads_(threads),
      limits_(std::move(limits)) {}

std::vector<Row> Sweep::block(std::int64_t b) const {
  const std::int64_t first = b * kBlock;
  const auto count = static_cast<std::size_t>(std::min(kBlock, space_.samples() - first));
  std::vector<Row> rows(count);
  for (std::size_t i = 0; i < count; ++i) {
    rows[i].sample = first + static_cast<std::int64_t>(i);
    rows[i].parameters = space_.point(rows[i].sample);
    rows[i].status = Row::kNotAssembled;
    rows[i].reached = kNan;
    rows[i].figures.assign(columns_.size() * figures_.size(), kNan);
  }
  Attempts attempts{std::vector<std::optional<Prepared>>(count), std::vector<std::exception_ptr>(count)};
  std::atomic<std::size_t> next = 0;
  Team team(threads_);
  team.run([&](int) {
    for (std::size_t i; (i = next++) < count;) {
      if (limits_.stop && limits_.stop()) return;
      try {
        attempts.prepared[i] = prepare_(rows[i].parameters);
      } catch (...) {
        attempts.errors[i] = std::current_exception();
      }
    }
  });
  const auto stopped = [&] { return limits_.stop && limits_.stop(); };
  if (stopped()) return {};
  try {
    Ensemble ensemble(
        count, [&](std::size_t i) { return attempts.take(i); }, limits_);
    const EnsembleSummary summary =
        ensemble.summarize(columns_, [&](std::int64_t, std::int64_t) { return !stopped(); });
    if (stopped()) return {};
    for (std::size_t i = 0; i < count; ++i) {
      const Ensemble::Outcome& outcome = ensemble.outcomes()[i];
      rows[i].why = outcome.cannot;
      if (!outcome.cannot.empty()) continue;
      rows[i].status = name(outcome.status.code);
      rows[i].reached = outcome.reached;
      for (std::size_t c = 0; c < columns_.size(); ++c) {
        for (std::size_t f = 0; f < figures_.size(); ++f) {
          rows[i].figures[c * figures_.size() + f] = figure_of(summary(i, c), figures_[f]);
        }
      }
    }
  } catch (const Error& e) {
    const bool none_is_prepared =
        std::all_of(attempts.errors.begin(), attempts.errors.end(), [](const auto& error) { return error != nullptr; });
    if (e.kind() == Error::Kind::environment || !none_is_prepared) throw;
    for (Row& row : rows) row.why = e.what();  // the first reason
  }
  return rows;
}

std::vector<std::string> Sweep::figures() const {
  std::vector<std::string> names;
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

std::string Sweep::line_of(const Row& row) {
  std::string line = std::to_string(row.sample);
  for (const double p : row.parameters) line += "," + text_of(p);
  line += "," + row.status + "," + text_of(row.reached);
  for (const double f : row.figures) line += "," + text_of(f);
  return line;
}

Row Sweep::parse(const std::string& line) const {
  std::vector<std::string> cells(1);
  for (const char c : line) {
    if (c == ',') {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  const std::size_t parameters = space_.ranges().size(), figures = columns_.size() * figures_.size();
  if (cells.size() != 3 + parameters + figures) refuse_line(line);
  Row row;
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
