#include "pictures/moving_svg.hpp"

#include <algorithm>
#include <cmath>

#include "decimal.hpp"

namespace assur::pictures {

std::string pixels(double x) {
  std::string text = fixed(std::round(x * 10) / 10 + 0.0, 1);
  if (text.ends_with(".0")) text.resize(text.size() - 2);
  return text;
}

std::string pixels(const Pixel& p) { return pixels(p[0]) + "," + pixels(p[1]); }

std::string pixels(const std::vector<Pixel>& points) {
  std::string text;
  for (const Pixel& p : points) text += (text.empty() ? "" : " ") + pixels(p);
  return text;
}

Pixel between(const Pixel& p, const Pixel& q, double share) {
  return {p[0] + share * (q[0] - p[0]), p[1] + share * (q[1] - p[1])};
}

double distance(const Pixel& p, const Pixel& q) { return std::hypot(p[0] - q[0], p[1] - q[1]); }

void MovingSvg::element(std::string_view tag, std::string_view attribute,
                        const std::function<std::string(std::size_t)>& value, std::string_view more) {
  std::vector<std::string> values;
  for (const std::size_t f : frames_) values.push_back(value(f));
  text_.append("<").append(tag).append(" ").append(attribute).append("=\"").append(values[0]).append("\" ");
  text_ += more;
  if (std::all_of(values.begin(), values.end(), [&](const std::string& v) { return v == values[0]; })) {
    text_ += "/>\n";
    return;
  }
  text_.append("><animate attributeName=\"").append(attribute).append("\"").append(timing(values)).append("/></");
  text_.append(tag).append(">\n");
}

std::string MovingSvg::timing(const std::vector<std::string>& values) const {
  std::string text = " dur=\"" + pixels(seconds_) + "s\" repeatCount=\"indefinite\" values=\"";
  for (std::size_t i = 0; i < values.size(); ++i) text += (i == 0 ? "" : ";") + values[i];
  return text + "\"";
}

void MovingSvg::around(int point, std::string_view elements) {
  std::vector<std::string> values;
  for (const std::size_t f : frames_) values.push_back(pixels(at(f, point)));
  text_ += "<g transform=\"translate(" + values[0] + ")\">";
  if (std::any_of(values.begin(), values.end(), [&](const std::string& v) { return v != values[0]; })) {
    text_ += "<animateTransform attributeName=\"transform\" type=\"translate\"" + timing(values) + "/>";
  }
  text_.append(elements).append("</g>\n");
}

void MovingSvg::bar(const std::function<std::vector<Pixel>(std::size_t)>& ends, std::string_view colour, double width) {
  const std::string name = "b" + std::to_string(bars_++);
  text_ += "<defs>";
  element(
      "polyline", "points", [&](std::size_t f) { return pixels(ends(f)); }, "id=\"" + name + "\"");
  text_ += "</defs>";
  for (const auto& [stroke, wide] : {std::pair(kPaper, width + 3), std::pair(colour, width)}) {
    text_ +=
        "<use href=\"#" + name + "\" stroke=\"" + std::string(stroke) + "\" stroke-width=\"" + pixels(wide) + "\"/>";
  }
  text_ += "\n";
}

std::string hatched(const Pixel& p, const Pixel& q, double size) {
  const double length = distance(p, q), stroke = 0.9 * size;
  if (!(length > 0)) return "";
  const double dx = (q[0] - p[0]) / length, dy = (q[1] - p[1]) / length;
  const int count = std::clamp(static_cast<int>(std::lround(length / (1.1 * size))), 2, 200);
  std::string d = "M" + pixels(p) + "L" + pixels(q);
  const std::string back = "l" + pixels(Pixel{-stroke * (dx + dy), -stroke * (dy - dx)});
  for (int k = 1; k <= count; ++k) d += "M" + pixels(between(p, q, static_cast<double>(k) / count)) + back;
  return "<path d=\"" + d + "\" stroke=\"" + std::string(kInk) + "\" stroke-width=\"1.2\"/>\n";
}

}  // namespace assur::pictures
