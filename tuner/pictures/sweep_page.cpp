#include "pictures/sweep_page.hpp"

#include <cmath>
#include <utility>

#include "output/format.hpp"
#include "pictures/html.hpp"
#include "pictures/packed.hpp"
#include "pictures/plot.hpp"

namespace assur::pictures {
namespace {

using output::number;
using sweep::DesignSample;

constexpr Size kSmall = {480, 340};
constexpr std::size_t kMostPairs = 6;  // plots of one parameter over another

constexpr std::string_view kStyle =
    ".grid{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,22rem),1fr));gap:1rem}"
    ".grid>div{min-width:0}.grid svg,.grid img{width:100%;height:auto}.grid p{margin:0}";

std::string about(const SweepPage& page, const DesignSample& row) {
  std::string text = "sample " + std::to_string(row.sample) + ", " + row.status;
  for (std::size_t i = 0; i < page.ranges.size(); ++i) {
    text += ", " + page.ranges[i].name + " = " + number(row.parameters[i]);
  }
  return text;
}

// The rows as points: done, jammed, not assembled, best. `y` is NaN where there is no point.
template <class X, class Y>
std::vector<Series> series_of(const SweepPage& page, const X& x, const Y& y) {
  std::vector<Series> all(4);
  all[0] = {.name = "done", .points = {}, .colour = 0, .mark = Series::Mark::dot};
  all[1] = {.name = "jammed", .points = {}, .colour = 1, .mark = Series::Mark::cross};
  all[2] = {.name = "not assembled", .points = {}, .colour = 2, .mark = Series::Mark::plus};
  all[3] = {.name = "best", .points = {}, .colour = Series::kInk, .mark = Series::Mark::diamond};
  const auto add = [&](Series& series, const DesignSample& row) {
    if (std::isfinite(y(row))) series.points.push_back({x(row), y(row), about(page, row)});
  };
  for (const DesignSample& row : page.rows) add(all[row.is_done() ? 0 : row.is_assembled() ? 1 : 2], row);
  for (const DesignSample& row : page.best) add(all[3], row);
  std::erase_if(all, [](const Series& s) { return s.points.empty(); });
  return all;
}

std::string drawn_in_grid(const Plot& plot) {
  if (plot.series.empty()) return {};
  return "<div>" + paragraph(plot.title, "faint") + drawn(plot, kSmall) + "</div>\n";
}

Axis axis(std::string title) { return {std::move(title), false, number}; }

// A figure over each parameter.
std::string plots_of_figure(const SweepPage& page, std::size_t f) {
  std::string plots;
  for (std::size_t p = 0; p < page.ranges.size(); ++p) {
    plots += drawn_in_grid({.title = page.figures[f] + " over " + page.ranges[p].name,
                            .x = axis(page.ranges[p].name),
                            .y = axis(page.figures[f]),
                            .series = series_of(
                                page, [p](const DesignSample& row) { return row.parameters[p]; },
                                [f](const DesignSample& row) { return row.figures[f]; }),
                            .guides = {}});
  }
  if (plots.empty()) return {};
  return "<h2>" + escaped(page.figures[f]) + "</h2>\n<div class=\"grid\">\n" + plots + "</div>\n";
}

// Parameters over each other: where samples are done, jam, or cannot be assembled.
std::string plots_of_ends(const SweepPage& page) {
  std::string plots;
  std::size_t pairs = 0;
  for (std::size_t p = 0; p < page.ranges.size(); ++p) {
    for (std::size_t q = p + 1; q < page.ranges.size() && pairs < kMostPairs; ++q, ++pairs) {
      plots += drawn_in_grid({.title = page.ranges[q].name + " over " + page.ranges[p].name,
                              .x = axis(page.ranges[p].name),
                              .y = axis(page.ranges[q].name),
                              .series = series_of(
                                  page, [p](const DesignSample& row) { return row.parameters[p]; },
                                  [q](const DesignSample& row) { return row.parameters[q]; }),
                              .guides = {}});
    }
  }
  if (plots.empty()) return {};
  return "<h2>Which samples are done</h2>\n<div class=\"grid\">\n" + plots + "</div>\n";
}

std::string base64(std::string_view bytes) {
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = i; k < i + 3; ++k)
      bits = bits << 8 | (k < bytes.size() ? static_cast<unsigned char>(bytes[k]) : 0U);
    append_letters(text, bits);
  }
  const std::size_t filled = (3 - bytes.size() % 3) % 3;
  return text.replace(text.size() - filled, filled, filled, '=');
}

std::string best_of(const SweepPage& page) {
  if (page.best.empty()) return {};
  using enum HtmlTable::Column;
  HtmlTable table{{"", "sample"}, {number, number}, {}};
  for (const sweep::Range& r : page.ranges) {
    table.titles.push_back(r.name);
    table.columns.push_back(number);
  }
  for (const std::string& f : page.figures) {
    table.titles.push_back(f);
    table.columns.push_back(number);
  }
  std::string motions;
  for (std::size_t i = 0; i < page.best.size(); ++i) {
    const DesignSample& row = page.best[i];
    HtmlTable::Row& cells = table.rows.emplace_back();
    cells.cells = {std::to_string(i + 1), std::to_string(row.sample)};
    for (const double value : row.parameters) cells.cells.push_back(output::number(value));
    for (const double value : row.figures) cells.cells.push_back(output::number(value));
    if (page.motions[i].empty()) continue;
    const std::string title = std::to_string(i + 1) + ": " + about(page, row);
    motions += "<div>" + paragraph(title, "faint") + "<img alt=\"" + escaped(title) +
               "\" src=\"data:image/svg+xml;base64," + base64(page.motions[i]) + "\"></div>\n";
  }
  std::string part = "<h2>The best by " + escaped(page.figures[0]) + "</h2>\n" + html(table);
  if (!motions.empty()) part += "<div class=\"grid\">\n" + motions + "</div>\n";
  return part;
}

}  // namespace

std::string page_of(const SweepPage& page) {
  const std::string title = page.scene + (page.ranges.empty() ? ": the best samples" : ": samples of a design space");
  std::string body = "<h1>" + escaped(title) + "</h1>\n" + paragraph(page.about, "faint");
  body += best_of(page);
  for (std::size_t f = 0; f < page.figures.size(); ++f) body += plots_of_figure(page, f);
  body += plots_of_ends(page);
  if (page.rows.empty()) return html_page(title, std::string(plot_style()) + std::string(kStyle), body);
  body += paragraph(
      "Dots: samples that are done. Crosses: jammed, with the figures up to there. Plus signs: not assembled. "
      "Diamonds: "
      "the best. A tooltip names the sample and its parameters.",
      "faint");
  return html_page(title, std::string(plot_style()) + std::string(kStyle), body);
}

}  // namespace assur::pictures
