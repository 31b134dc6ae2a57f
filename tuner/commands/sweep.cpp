// assur sweep SCENE
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <optional>
#include <string>
#include <system_error>
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
#include "sweep/sweep.hpp"

namespace assur::command {
namespace {

using output::counted;
using output::grouped;
using output::Json;
using output::Progress;
using sweep::DesignSample;

// Counts of all rows, and the best of them.
struct Tally {
  std::int64_t rows = 0, done = 0, jammed = 0, not_assembled = 0;
  std::size_t most = 0;            // samples to keep in `best`
  std::vector<DesignSample> best;  // arrived, with the smallest first figures; ascending
  std::int64_t stride = 1;         // of the rows in `shown`, evenly spaced over the samples
  std::vector<DesignSample> shown;
  std::int64_t example = -1;  // the first sample with a known reason why it was not assembled
  std::string why;

  void take(const DesignSample& row) {
    if (rows % stride == 0) shown.push_back(row);
    ++rows;
    not_assembled += row.is_assembled() ? 0 : 1;
    if (example < 0 && !row.why.empty()) {
      example = row.sample;
      why = row.why;
    }
    done += row.is_done() ? 1 : 0;
    jammed += row.is_assembled() && !row.is_done() ? 1 : 0;
    if (!row.is_done() || most == 0 || std::isnan(row.figures[0])) return;
    const auto place =
        std::upper_bound(best.begin(), best.end(), row,
                         [](const DesignSample& a, const DesignSample& b) { return a.figures[0] < b.figures[0]; });
    best.insert(place, row);
    if (best.size() > most) best.pop_back();
  }
};

Parameters with(const Parameters& set, const std::vector<sweep::Range>& vary, const std::vector<double>& values) {
  Parameters all = set;
  for (std::size_t i = 0; i < vary.size(); ++i) all[vary[i].name] = values[i];
  return all;
}

// Empty if there is no valid scene at this point.
std::optional<Scene> scene_or_none(const std::function<Scene(const std::vector<double>&)>& scene_at,
                                   const std::vector<double>& point) {
  try {
    return scene_at(point);
  } catch (const Error& e) {
    if (e.kind() == Error::Kind::environment) throw;
    return std::nullopt;
  }
}

// Empty if no path is compared. columns: outputs of the scene.
std::optional<sweep::Trace> trace_of(const SweepOptions& options, const Scene& scene,
                                     const std::vector<std::string>& columns) {
  if (options.target.empty()) return std::nullopt;
  sweep::check_point(options.trace, scene, columns);
  sweep::Trace trace{options.trace, curve_in(options.target), options.compare};
  sweep::check_target(trace, scene);
  return trace;
}

void check(const Common& common, const SweepOptions& options) {
  if (options.vary.empty()) refuse("--vary", "give the parameters to vary, with their ranges: a=LOW:HIGH,...");
  if (options.target.empty() && !options.trace.empty()) {
    refuse("--trace", "needs a curve to compare the path with: --target FILE");
  }
  if (!options.target.empty() && options.trace.empty()) {
    refuse("--target", "give the point whose path is compared with the curve: --trace POINT");
  }
  if (options.out == "-") refuse("--out", "rows are kept in a file, so that a sweep can go on; give its name");
  for (std::size_t i = 0; i < options.vary.size(); ++i) {
    const std::string& name = options.vary[i].name;
    for (std::size_t j = 0; j < i; ++j) {
      if (options.vary[j].name == name) refuse("--vary", "\"" + name + "\" is given twice");
    }
    if (common.set.contains(name)) refuse("--set", "\"" + name + "\" is varied, too; give it only once");
  }
  if (options.strategy != "auto" && parse_strategy(options.strategy).run.chunks > 1) {
    refuse("--strategy", "samples use the lanes and threads; remove +chunks=");
  }
}

// The file of rows. A file of an earlier call is continued after its last complete row, once its last block is found to
// be the same; until then it is unchanged.
class RowFile {
 public:
  // Of the samples from `first` up to, without, `last`.
  RowFile(std::string name, const sweep::Sweep& sweep, std::int64_t first, std::int64_t last, Tally& tally)
      : name_(std::move(name)), sweep_(sweep), first_(first), wanted_(last - first) {
    read(tally);
    if (complete_ == 0) open();
  }

  [[nodiscard]] std::int64_t rows() const { return rows_; }

  // The next rows, or rows that the file has already: they must be equal.
  void put(const DesignSample& row, Tally& tally) {
    const std::string line = sweep::Sweep::line_of(row);
    const std::int64_t at = row.sample - first_;
    if (at < rows_) {
      const std::string& had = last_[static_cast<std::size_t>(at - (rows_ - static_cast<std::int64_t>(last_.size())))];
      if (had != line) {
        refuse("--out", name_ + " has another row for sample " + std::to_string(row.sample) +
                            ": it was made by another scene, seed, build or plan; choose another file or remove it");
      }
      return;
    }
    if (!out_.is_open()) open();
    tally.take(row);
    out_ << line << '\n';
  }
  void flush() {
    if (out_.is_open() && !out_.flush()) fail();
  }

 private:
  // Begins the file, or drops the row of an earlier call that is not complete.
  void open() {
    std::error_code trouble;
    if (complete_ > 0) std::filesystem::resize_file(name_, complete_, trouble);
    out_.open(name_, (complete_ > 0 ? std::ios::app : std::ios::trunc) | std::ios::binary);
    if (complete_ == 0) out_ << sweep_.header() << '\n';
    if (trouble || !out_.flush()) fail();
  }

  // Reads the rows of an earlier call.
  void read(Tally& tally) {
    std::ifstream in(name_, std::ios::binary);
    std::string line;
    const auto next = [&] { return std::getline(in, line) && !in.eof(); };  // without end it is not complete
    if (!in || (!next() && sweep_.header().starts_with(line))) return;
    if (line != sweep_.header()) {
      refuse("--out", name_ + " has not the columns of this sweep; choose another file or remove it");
    }
    complete_ = line.size() + 1;
    while (next()) {
      if (rows_ == wanted_) refuse_longer();
      const DesignSample row = sweep_.parse(line);
      if (row.sample != first_ + rows_) {
        refuse("--out", name_ + " has sample " + std::to_string(row.sample) + " where this sweep has " +
                            std::to_string(first_ + rows_) + "; choose another file or remove it");
      }
      tally.take(row);
      complete_ += line.size() + 1;
      if ((first_ + rows_) % sweep::Sweep::kBlock == 0) last_.clear();
      last_.push_back(line);
      ++rows_;
    }
    if (rows_ == wanted_ && !line.empty()) refuse_longer();
  }
  [[noreturn]] void refuse_longer() const {
    refuse("--out", name_ + " has more than the " + counted(wanted_, "sample") +
                        " of this sweep; choose another file or remove it");
  }
  [[noreturn]] void fail() const { throw Error(Error::Kind::environment, {{"--out", name_ + " cannot be written"}}); }

  std::string name_;
  const sweep::Sweep& sweep_;
  std::int64_t first_, wanted_, rows_ = 0;  // rows of an earlier call
  std::uintmax_t complete_ = 0;             // bytes of these rows and the first line
  std::vector<std::string> last_;           // those of the last block among them
  std::ofstream out_;
};

void print(const Common& common, const SweepOptions& options, const sweep::DesignSpace& space, const Tally& tally,
           std::int64_t wanted, const std::vector<std::string>& figures, double seconds) {
  if (common.json) {
    Json best = Json::array();
    for (const DesignSample& row : tally.best) {
      Json all = Json::object();
      for (std::size_t i = 0; i < figures.size(); ++i) all[figures[i]] = row.figures[i];
      best.push_back(
          {{"sample", row.sample}, {"parameters", with({}, space.ranges(), row.parameters)}, {"figures", all}});
    }
    output::print(std::cout,
                  {{"samples", tally.rows},
                   {"done", tally.done},
                   {"jammed", tally.jammed},
                   {"not_assembled", tally.not_assembled},
                   {"why_not", tally.example < 0 ? Json(nullptr) : Json{{"sample", tally.example}, {"why", tally.why}}},
                   {"best", best},
                   {"seconds", seconds},
                   {"out", options.out}});
    return;
  }
  output::Page page(std::cout);
  page.title(options.scene + ": " + grouped(tally.rows) + " of " + counted(wanted, "sample"));
  page.fact("done", grouped(tally.done));
  page.fact("jammed", grouped(tally.jammed));
  page.fact("not assembled", grouped(tally.not_assembled));
  if (tally.example >= 0) page.fact("", "sample " + grouped(tally.example) + ": " + output::one_line(tally.why));
  std::vector<std::string> best;
  for (const DesignSample& row : tally.best) {
    std::string text = "sample " + grouped(row.sample) + ": " + figures[0] + " = " + output::number(row.figures[0]);
    for (std::size_t i = 0; i < row.parameters.size(); ++i) {
      text += ", " + space.ranges()[i].name + " = " + output::number(row.parameters[i]);
    }
    best.push_back(text);
  }
  page.list("best", best);
  page.fact("time", output::duration(seconds));
  page.fact("rows", options.out);
}

std::string sentence_of(const Tally& tally, std::int64_t wanted) {
  return grouped(tally.rows) + " of " + counted(wanted, "sample") + ": " + grouped(tally.done) + " done, " +
         grouped(tally.jammed) + " jammed, " + grouped(tally.not_assembled) + " not assembled.";
}

}  // namespace

std::pair<std::int64_t, std::int64_t> range_of(const SweepOptions& options) {
  const auto [from, to] = options.range.value_or(std::pair<std::int64_t, std::int64_t>{0, options.samples});
  if (from < 0 || to <= from || to > options.samples) {
    refuse("--range", "expects I:J with 0 <= I < J <= " + std::to_string(options.samples) + ", not " +
                          std::to_string(from) + ":" + std::to_string(to));
  }
  return {from, to};
}

int sweep(const Common& common, const SweepOptions& options) {
  if (options.scene == "linkages" || options.scene.starts_with("linkages:")) return sweep_linkages(common, options);
  check(common, options);
  refuse_overwriting(common, {{"--out", options.out}, {"--html", options.html}}, {options.scene, options.target});
  const sweep::DesignSpace space(options.vary, options.sampler, options.samples, options.seed);
  const auto [first, last] = range_of(options);

  RunOptions as_run;
  as_run.scene = options.scene;
  as_run.outputs = options.outputs;
  as_run.strategy = options.strategy;
  as_run.mode = Mode::throughput;
  PrepareOptions how = how_of(common, as_run);
  if (!how.budget) how.budget = this_machine().budget();  // determined once for all samples
  const auto scene_at = [&](const std::vector<double>& point) {
    return scene_of(common, as_run, with(common.set, space.ranges(), point));
  };
  std::vector<double> middle;
  for (const sweep::Range& r : space.ranges()) middle.push_back(r.low + (r.high - r.low) / 2);
  const Scene scene = scene_at(middle);
  refuse_overwriting({{"--out", options.out}, {"--html", options.html}}, scene);
  const std::vector<std::string> columns = sweep::columns_of(scene);
  if (columns.empty()) refuse("--outputs", "the scene has no outputs, so that there is nothing to keep");

  if (const std::optional<Scene> one = scene_or_none(scene_at, space.point(first))) {
    sweep::check_same_times(scene, *one);
  }
  StepSettings settings;
  settings.stop = [] { return Interrupt::requested(); };
  sweep::Sweep sweep(space, scene, how, columns, options.reduce, trace_of(options, scene, columns), settings);

  output::Replacement html("--html", options.html);
  Tally tally;
  tally.stride = (last - first + pictures::kRowsOfPage - 1) / pictures::kRowsOfPage;
  tally.most = static_cast<std::size_t>(options.best);
  RowFile file(options.out, sweep, first, last, tally);
  Progress progress(common.quiet, "sample");
  const double begin = measure::StepTimes::steady();
  const Interrupt interrupt;
  bool stopped = false;
  // The block of the last row of an earlier call is computed again, to compare it.
  for (std::int64_t b = (first + std::max<std::int64_t>(file.rows() - 1, 0)) / sweep::Sweep::kBlock;
       !stopped && b * sweep::Sweep::kBlock < last; ++b) {
    const std::vector<DesignSample> rows = sweep.block(b);
    stopped = rows.empty();
    for (const DesignSample& row : rows) {
      if (row.sample >= first && row.sample < last) file.put(row, tally);
    }
    file.flush();
    progress.show(measure::StepTimes::steady() - begin, tally.rows, last - first);
  }
  progress.clear();
  if (html) {
    pictures::SweepPage page{options.scene, {}, space.ranges(), sweep.figures(), std::move(tally.shown),
                             tally.best,    {}};
    page.about = {sentence_of(tally, last - first), "Shown: " + counted(page.rows.size(), "sample") + "."};
    for (const DesignSample& row : tally.best)
      page.motions.push_back(moving_picture_of(prepare(scene_at(row.parameters), how), how, as_run));
    html.stream() << pictures::page_of(page);
    html.put();
  }
  print(common, options, space, tally, last - first, sweep.figures(), measure::StepTimes::steady() - begin);
  return stopped ? kInterrupted : kDone;
}

}  // namespace assur::command
