#include "pictures/outputs_over_time.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "output/format.hpp"
#include "pictures/plot.hpp"
#include "pictures/quantities.hpp"
#include "pictures/svg.hpp"
#include "plan/preparation.hpp"

namespace assur::pictures {
namespace {

constexpr Size kDiagram{960, 260};
constexpr int kHead = 44, kLine = 20;      // px, height of the title and of each line below it
constexpr std::size_t kMostPoints = 2000;  // of a curve, about two for each pixel

// Keeps the smallest and the largest value of each stretch, so that no peak is lost.
std::vector<Point> curve(const Trajectory& trajectory, std::size_t column) {
  const std::size_t rows = trajectory.rows(), stretch = std::max<std::size_t>(2 * rows / kMostPoints, 2);
  std::vector<Point> points;
  const auto add = [&](std::size_t k) { points.push_back({trajectory.times()[k], trajectory(k, column)}); };
  for (std::size_t begin = 0; begin < rows; begin += stretch) {
    const std::size_t end = std::min(begin + stretch, rows);
    std::size_t low = begin, high = begin;
    for (std::size_t k = begin; k < end; ++k) {
      if (trajectory(k, column) < trajectory(low, column)) low = k;
      if (trajectory(k, column) > trajectory(high, column)) high = k;
    }
    add(std::min(low, high));
    if (low != high) add(std::max(low, high));
  }
  return points;
}

Plot diagram(const Trajectory& trajectory, const Quantity& q) {
  Plot plot;
  plot.title = q.title + " over time";
  plot.x = {"t, s", false, output::number};
  plot.y = {q.title + (q.unit.empty() ? "" : ", " + q.unit), false, output::number};
  for (std::size_t i = 0; i < q.columns.size(); ++i) {
    Series series{.name = {},
                  .points = curve(trajectory, q.columns[i]),
                  .colour = static_cast<int>(i),
                  .mark = trajectory.rows() == 1 ? Series::Mark::dot : Series::Mark::none,
                  .line = Series::Line::straight};
    plot.series.push_back(std::move(series));
  }
  return plot;
}

// Letters x, y, z in the colours of their curves, at the top right of the diagram.
std::string key(const Quantity& q) {
  std::string out;
  for (std::size_t i = 0; q.columns.size() > 1 && i < q.columns.size(); ++i) {
    const int x = kDiagram.width - 20 * static_cast<int>(q.columns.size() - i);
    out += svg::text("key c" + std::to_string(i), x, 14, "start", std::string_view("xyz").substr(i, 1));
  }
  return out;
}

// The style of plots without CSS variables, which few programs other than browsers support.
std::string style() {
  static constexpr std::array kColours = {"#0068a5", "#b36b00", "#00805d"};
  std::string text =
      "text { font: 13px sans-serif; fill: #1b1f24; } .tick, .faint { fill: #59636e; } .title { font-weight: 600; }\n"
      ".key { font-weight: 700; } .head { font-size: 18px; font-weight: 600; }\n"
      ".grid { stroke: #d5dae0; stroke-width: 1; } .line { fill: none; stroke-width: 1.5; }\n";
  for (std::size_t i = 0; i < kColours.size(); ++i) {
    const std::string name = ".c" + std::to_string(i), colour = kColours[i];
    text +=
        ".line" + name + " { stroke: " + colour + "; } .mark" + name + ", .key" + name + " { fill: " + colour + "; }\n";
  }
  return text;
}

std::vector<std::string> sentences(const std::vector<Quantity>& all, const std::string& why_ended) {
  std::vector<std::string> found;
  if (!why_ended.empty()) found.push_back("The motion ends early: " + why_ended + ".");
  if (all.size() > kMostDiagrams) {
    std::vector<std::string> left_out;
    for (std::size_t i = kMostDiagrams; i < all.size(); ++i) {
      if (left_out.empty() || left_out.back() != all[i].output) left_out.push_back(all[i].output);
    }
    found.push_back("Left out (select outputs with --outputs): " + output::listed(left_out, 12) + ".");
  }
  return found;
}

}  // namespace

std::string outputs_over_time(const Prepared& prepared, const Trajectory& trajectory, const std::string& why_ended) {
  const std::vector<Quantity> all = quantities(prepared.structure());
  const std::vector<std::string> below = sentences(all, why_ended);
  const std::size_t shown = std::min(all.size(), kMostDiagrams);
  int y = kHead + kLine * static_cast<int>(below.size());
  const std::string width = std::to_string(kDiagram.width);
  const std::string height = std::to_string(y + kDiagram.height * static_cast<int>(shown));
  std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + width + "\" height=\"" + height +
                    "\" viewBox=\"0 0 " + width + " " + height + "\" style=\"max-width:100%;height:auto\">\n<style>\n" +
                    style() + "</style>\n";
  out += "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
  out += svg::text("head", 2, 24, "start", prepared.name());
  for (std::size_t i = 0; i < below.size(); ++i) {
    out += svg::text("faint", 2, kHead + kLine * static_cast<int>(i), "start", below[i]);
  }
  for (std::size_t i = 0; i < shown; ++i, y += kDiagram.height) {
    out += "<svg y=\"" + std::to_string(y) + "\" width=\"" + width + "\" height=\"" + std::to_string(kDiagram.height) +
           "\">\n" + drawn(diagram(trajectory, all[i]), kDiagram) + key(all[i]) + "</svg>\n";
  }
  return out + "</svg>\n";
}

}  // namespace assur::pictures
