// assur sweep linkages
#include <algorithm>
#include <charconv>
#include <cmath>
#include <iostream>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "assur/machine.hpp"
#include "commands/commands.hpp"
#include "commands/interrupt.hpp"
#include "commands/run_parts.hpp"
#include "measure/step_times.hpp"
#include "output/format.hpp"
#include "output/json.hpp"
#include "output/page.hpp"
#include "output/progress.hpp"
#include "output/replace_file.hpp"
#include "pictures/sweep_page.hpp"
#include "sweep/linkage_file.hpp"

namespace assur::command {
namespace {

using output::counted;
using output::grouped;
using output::Json;
using output::Progress;

constexpr std::int64_t kBlock = 4096;  // samples that are moved at once

int whole(std::string_view text, int least, int most, const std::string& what) {
  int value = 0;
  const auto [end, trouble] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (trouble != std::errc() || end != text.data() + text.size() || value < least || value > most) {
    refuse("SCENE", what + " expects a whole number from " + std::to_string(least) + " to " + std::to_string(most) +
                        ", not \"" + std::string(text) + "\"");
  }
  return value;
}

// "linkages:joints=5..20,times=200,precision=single"
sweep::LinkageSet set_of(const SweepOptions& options) {
  sweep::LinkageSet set;
  set.seed = options.seed;
  std::tie(set.first, set.last) = range_of(options);
  int times = 200;
  std::string_view rest = options.scene;
  rest.remove_prefix(std::min(rest.size(), std::string_view("linkages:").size()));
  while (!rest.empty()) {
    const std::string_view word = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), word.size() + 1));
    const std::size_t equals = word.find('=');
    const std::string_view name = word.substr(0, equals);
    const std::string_view value = equals == std::string_view::npos ? "" : word.substr(equals + 1);
    if (name == "joints") {
      using sweep::JointCounts;
      const std::size_t dots = value.find("..");
      set.joints.least = whole(value.substr(0, dots), JointCounts::kFewest, JointCounts::kMost, "joints=");
      set.joints.most = dots == std::string_view::npos
                            ? set.joints.least
                            : whole(value.substr(dots + 2), set.joints.least, JointCounts::kMost, "joints=..");
    } else if (name == "times") {
      times = whole(value, 2, 1000000, "times=");
    } else if (name == "precision" && (value == "single" || value == "double")) {
      set.single = value == "single";
    } else {
      refuse("SCENE", "linkages has the options joints=5..20, times=200 and precision=single or double, not \"" +
                          std::string(word) + "\"");
    }
  }
  if (!options.target.empty()) set.target = curve_in(options.target);
  for (int k = 0; k < times; ++k) set.times.push_back(k / static_cast<double>(times));  // of one turn
  return set;
}

void check(const Common& common, const SweepOptions& options) {
  if (!options.vary.empty()) refuse("--vary", "random linkages have no parameters to vary");
  if (options.sampler != sweep::Sampler::random) refuse("--sampler", "linkages are random");
  if (!common.set.empty()) refuse("--set", "random linkages have no parameters");
  if (options.reduce != SweepOptions().reduce) refuse("--reduce", "linkages have no figures but the distance");
  if (!options.html.empty() && options.best == 0) refuse("--html", "shows the best samples; say how many: --best K");
  if (!options.outputs.empty()) refuse("--outputs", "of a linkage, the path of the last joint is kept");
  const std::string without_target = "needs a curve to compare paths with: --target FILE";
  if (!options.html.empty() && options.target.empty()) refuse("--html", without_target);
  if (options.best > 0 && options.target.empty()) refuse("--best", without_target);
  if (options.strategy != "auto") refuse("--strategy", "linkages are solved in closed form");
  if (!options.out.ends_with(".h5") && !options.out.ends_with(".hdf5")) {
    refuse("--out", "linkages are written as HDF5; give a name that ends with .h5");
  }
}

// The rows of the samples from `first` up to, without, `last`. Empty if interrupted, which the report says.
std::vector<sweep::LinkageRow> rows_of(const sweep::LinkageSet& set, std::int64_t first, std::int64_t last,
                                       const FleetOptions& how, FleetReport& report) {
  std::vector<sweep::LinkageRow> rows(static_cast<std::size_t>(last - first));
  std::vector<double> turn = set.times;
  turn.push_back(1);  // a linkage must not jam after the last time of its path
  const auto source = [&](std::size_t i, Linkage& to) {
    sweep::random_linkage(set.seed, static_cast<std::uint64_t>(first) + i, set.joints, to);
  };
  const auto sink = [&](std::size_t i, const LinkageMotion& motion) {
    if (!motion.status.ok()) return;
    sweep::LinkageRow& row = rows[i];
    row.sample = first + static_cast<std::int64_t>(i);
    source(i, row.linkage);
    const std::span<const PlanePoint> path = motion.path.first(set.times.size());
    row.frame = frame_of(path);
    row.error = motion.error;
    row.curve.resize(path.size());
    normalize(path, row.frame, row.curve);
    if (!set.target.empty()) row.distance = shape_distance(row.curve, set.target);
  };
  report = Fleet(rows.size(), source).stream(sink, turn, how);
  if (report.interrupted) return {};
  std::erase_if(rows, [](const sweep::LinkageRow& row) { return row.curve.empty(); });
  return rows;
}

// The rows with the smallest distances from the target, ascending; at most `most`.
std::vector<sweep::DesignSample> best_of(const sweep::LinkageFile& file, std::int64_t most) {
  std::vector<std::pair<std::int64_t, double>> all = file.distances();
  std::erase_if(all, [](const auto& row) { return std::isnan(row.second); });
  const auto count = std::min(all.size(), static_cast<std::size_t>(most));
  std::partial_sort(
      all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count), all.end(),
      [](const auto& a, const auto& b) { return std::tie(a.second, a.first) < std::tie(b.second, b.first); });
  std::vector<sweep::DesignSample> best;
  for (std::size_t i = 0; i < count; ++i) {
    best.push_back({.sample = all[i].first,
                    .parameters = {},
                    .status = "ok",
                    .reached = 1,
                    .figures = {all[i].second},
                    .why = {}});
  }
  return best;
}

void write_page(const Common& common, const SweepOptions& options, const sweep::LinkageSet& set,
                const std::vector<sweep::DesignSample>& best, output::Replacement& page) {
  pictures::SweepPage about{options.scene,
                            {"Distances of paths from the curve in " + options.target + ", in normal places."},
                            {},
                            {"distance"},
                            {},
                            best,
                            {}};
  PrepareOptions how;
  how.budget = common.threads > 0 ? ThreadBudget{common.threads} : this_machine().budget();
  for (const sweep::DesignSample& row : best) {
    Linkage linkage;
    sweep::random_linkage(set.seed, static_cast<std::uint64_t>(row.sample), set.joints, linkage);
    const TimeGrid turn{0, 1, 1.0 / static_cast<double>(set.times.size())};
    about.motions.push_back(moving_picture_of(prepare(scene_of(linkage, turn), how), how, {}));
  }
  page.stream() << pictures::page_of(about);
  page.put();
}

// before: samples of an earlier call.
void print(const Common& common, const SweepOptions& options, const sweep::LinkageCounts& counts,
           const std::vector<sweep::DesignSample>& best, std::int64_t before, std::int64_t wanted, double seconds) {
  if (common.json) {
    Json list = Json::array();
    for (const sweep::DesignSample& row : best) {
      list.push_back(
          {{"sample", row.sample}, {"parameters", Json::object()}, {"figures", {{"distance", row.figures[0]}}}});
    }
    output::print(std::cout, {{"samples", counts.samples},
                              {"done", counts.rows},
                              {"jammed", counts.jammed},
                              {"not_assembled", counts.not_closed},
                              {"inaccurate", counts.inaccurate},
                              {"best", list},
                              {"seconds", seconds},
                              {"out", options.out}});
    return;
  }
  output::Page page(std::cout);
  page.title(options.scene + ": " + grouped(counts.samples) + " of " + counted(wanted, "sample"));
  if (before > 0) page.fact("from before", grouped(before));
  page.fact("done", grouped(counts.rows));
  page.fact("jammed", grouped(counts.jammed));
  page.fact("not assembled", grouped(counts.not_closed));
  if (counts.inaccurate > 0) page.fact("inaccurate", grouped(counts.inaccurate) + ", left out");
  std::vector<std::string> lines;
  for (const sweep::DesignSample& row : best) {
    lines.push_back("sample " + grouped(row.sample) + ": distance = " + output::number(row.figures[0]));
  }
  page.list("best", lines);
  page.fact("time", output::duration(seconds));
  page.fact("rows", options.out);
}

}  // namespace

std::vector<PlanePoint> curve_in(const std::string& file) {
  std::vector<PlanePoint> curve;
  for (const Parameters& row : read_variants(file)) {
    if (row.size() != 2 || !row.contains("x") || !row.contains("y")) {
      refuse("--target", file + " needs the two columns x and y");
    }
    curve.push_back({row.at("x"), row.at("y")});
  }
  if (curve.size() < 3) refuse("--target", file + " needs at least three points");
  return curve;
}

int sweep_linkages(const Common& common, const SweepOptions& options) {
  check(common, options);
  const sweep::LinkageSet set = set_of(options);
  refuse_overwriting(common, {{"--out", options.out}, {"--html", options.html}}, {options.target});
  output::Replacement html("--html", options.html);
  sweep::LinkageFile file(options.out, set);
  FleetOptions how;
  how.threads = common.threads > 0 ? common.threads : this_machine().budget().threads;
  how.observer = [](std::int64_t, std::int64_t) { return Interrupt::requested(); };
  Progress progress(common.quiet, "sample");
  const Interrupt interrupt;
  const double begin = measure::StepTimes::steady();
  const std::int64_t before = file.counts().samples, wanted = set.last - set.first;
  bool interrupted = false;
  while (file.counts().samples < wanted && !interrupted) {
    const std::int64_t done = file.counts().samples, more = std::min(kBlock, wanted - done);
    FleetReport report;
    const std::vector<sweep::LinkageRow> rows = rows_of(set, set.first + done, set.first + done + more, how, report);
    interrupted = report.interrupted;
    if (interrupted) break;
    const auto number = [](std::size_t n) { return static_cast<std::int64_t>(n); };
    file.append(rows, {more, 0, number(report.jammed), number(report.not_closed), number(report.inaccurate)});
    progress.show(measure::StepTimes::steady() - begin, file.counts().samples, wanted);
  }
  progress.clear();
  const std::vector<sweep::DesignSample> best = best_of(file, options.best);
  if (html) write_page(common, options, set, best, html);
  print(common, options, file.counts(), best, before, wanted, measure::StepTimes::steady() - begin);
  return interrupted ? kInterrupted : kDone;
}

}  // namespace assur::command
