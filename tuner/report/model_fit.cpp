#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "median.hpp"
#include "numbers.hpp"
#include "output/format.hpp"
#include "pictures/plot.hpp"
#include "pictures/ticks.hpp"
#include "report/sections.hpp"
#include "tuning/refinement.hpp"
#include "tuning/replay.hpp"

namespace assur::report {
namespace {

constexpr std::size_t kMostShown = 400;  // points in the diagram; the figures use all samples

struct Fit {
  const Sample* sample;
  Prediction expected;

  // The factor between expected and measured time, at least 1.
  [[nodiscard]] double factor() const { return std::exp(std::abs(std::log(expected.seconds / sample->seconds))); }
};

std::vector<Fit> fits(const std::vector<tuning::CellResult>& cells, const PerformanceModel& model, bool held_out) {
  std::vector<Fit> out;
  for (const tuning::CellResult& c : cells) {
    if (held_out && !c.cell.held_out) continue;
    for (const tuning::Result& r : c.results) {
      const Sample& s = r.sample;
      if (s.kernel == Kernel::meeting || s.kernel == Kernel::step || s.strategy.run.threads > 1) continue;
      out.push_back({&s, s.kernel == Kernel::pack ? model.pack(s.shape, s.strategy)
                                                  : model.kernel(s.kernel, s.shape, s.strategy)});
    }
  }
  return out;
}

std::string item_of(const Sample& s) {
  return std::string(name(s.kernel)) + ", n = " + std::to_string(s.shape.n) + ", nnz = " + std::to_string(s.shape.nnz) +
         ", " + output::counted(s.shape.groups, "group");
}

pictures::Plot scatter(const std::vector<Fit>& all) {
  pictures::Plot plot;
  plot.title = "Expected time over measured time";
  plot.x = {"measured, one call", true, pictures::time_text};
  plot.y = {"expected", true, pictures::time_text};
  double low = kInfinity, high = 0;
  for (const Fit& f : all) {
    low = std::min({low, f.sample->seconds, f.expected.seconds});
    high = std::max({high, f.sample->seconds, f.expected.seconds});
  }
  for (const double factor : {1.0, 2.0, 0.5}) {
    plot.series.push_back({.name = factor == 1 ? "equal, and a factor of two above and below" : "",
                           .points = {{low / std::min(factor, 1.0), low * std::max(factor, 1.0)},
                                      {high / std::max(factor, 1.0), high * std::min(factor, 1.0)}},
                           .colour = pictures::Series::kInk,
                           .mark = pictures::Series::Mark::none,
                           .line = pictures::Series::Line::straight});
  }
  using Mark = pictures::Series::Mark;
  constexpr std::array kKernels = {std::pair(Kernel::evaluate, Mark::plus), std::pair(Kernel::factor, Mark::dot),
                                   std::pair(Kernel::solve, Mark::triangle), std::pair(Kernel::pack, Mark::square)};
  const std::size_t stride = (all.size() + kMostShown - 1) / kMostShown;
  for (std::size_t k = 0; k < kKernels.size(); ++k) {
    pictures::Series series{.name = std::string(name(kKernels[k].first)),
                            .points = {},
                            .colour = static_cast<int>(k),
                            .mark = kKernels[k].second};
    for (std::size_t i = 0; i < all.size(); i += stride) {
      const Sample& s = *all[i].sample;
      if (s.kernel != kKernels[k].first) continue;
      series.points.push_back({s.seconds, all[i].expected.seconds,
                               item_of(s) + ", " + to_string(s.strategy) + ": measured " + output::duration(s.seconds) +
                                   " (" + output::grouped(s.repetitions) + " calls, spread " +
                                   percent(s.spread / s.seconds) + "), expected " +
                                   output::duration(all[i].expected.seconds)});
    }
    if (!series.points.empty()) plot.series.push_back(std::move(series));
  }
  return plot;
}

}  // namespace

Section model_fit(const Knowledge& knowledge, const Conditions&) {
  Section out{"model-fit", "Accuracy of predicted times"};
  if (!knowledge.tuning) {
    out.body = paragraph("There is no finished tuning run of this machine.", "notice");
    return out;
  }
  const std::vector<tuning::CellResult> cells = tuning::cells_of(knowledge.tuning->samples);
  const PerformanceModel model = tuning::model_of(cells);
  std::vector<Fit> all = fits(cells, model, true);
  const bool unseen = !all.empty();
  if (!unseen) all = fits(cells, model, false);

  std::vector<double> factors;
  const std::string origin = unseen ? "predicted by a model without its cell" : "predicted by a model that includes it";
  for (const Fit& f : all) {
    const Sample& s = *f.sample;
    factors.push_back(f.factor());
    const std::string strategy = to_string(s.strategy);
    const auto count = static_cast<int>(std::min<std::int64_t>(s.repetitions, std::numeric_limits<int>::max()));
    out.measurements.push_back({item_of(s), strategy, "seconds per call, measured", "s", s.seconds,
                                "tuning run " + std::to_string(knowledge.tuning->run.id), count, s.spread / s.seconds,
                                s.backward_error});
    out.measurements.push_back({item_of(s), strategy, "seconds per call, expected", "s", f.expected.seconds,
                                origin + ", " + std::string(name(f.expected.origin))});
  }
  const double median = quantile(factors, 0.5), p95 = quantile(factors, 0.95), most = quantile(factors, 1);
  const auto add = [&](const char* quantity, double value) {
    out.measurements.push_back(
        {"all samples", "", quantity, "1", value, "computed from " + output::counted(factors.size(), "sample")});
  };
  add("expected over measured, off by a factor, median", median);
  add("expected over measured, off by a factor, p95", p95);
  add("expected over measured, off by a factor, max", most);
  const auto within =
      static_cast<double>(std::count_if(all.begin(), all.end(), [](auto& f) { return f.factor() <= 2; }));
  out.body = paragraph(
      std::string(unseen ? "Held-out samples, predicted by a model of all other samples. "
                         : "No samples were held out: the model includes the samples compared here. ") +
      "Predictions are wrong by a factor of " + output::fixed(median) + " (median), " + output::fixed(p95) +
      " (95th percentile), " + output::fixed(most) + " (max); " +
      percent(within / static_cast<double>(std::max<std::size_t>(factors.size(), 1))) + " are within a factor of two.");
  out.body += pictures::figure(scatter(all));
  return out;
}

}  // namespace assur::report
