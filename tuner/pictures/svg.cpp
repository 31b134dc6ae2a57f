#include "pictures/svg.hpp"

#include "decimal.hpp"
#include "output/format.hpp"
#include "pictures/html.hpp"

namespace assur::pictures::svg {

std::string at(double value) { return fixed(value, 1); }

double width(std::string_view text) { return kLetter * static_cast<double>(output::display_width(text)); }

std::string text(std::string_view css_class, double x, double y, std::string_view anchor, std::string_view what) {
  std::string out = "<text class=\"";
  out.append(css_class).append("\" x=\"").append(at(x)).append("\" y=\"").append(at(y));
  return out.append("\" text-anchor=\"").append(anchor).append("\">").append(escaped(what)).append("</text>\n");
}

std::string line(std::string_view css_class, double x1, double y1, double x2, double y2) {
  return "<line class=\"" + std::string(css_class) + "\" x1=\"" + at(x1) + "\" y1=\"" + at(y1) + "\" x2=\"" + at(x2) +
         "\" y2=\"" + at(y2) + "\"/>\n";
}

std::string rectangle(double x, double y, double w, double h, std::string_view about, std::string_view look) {
  std::string out = "<rect x=\"" + at(x) + "\" y=\"" + at(y) + "\" width=\"" + at(w) + "\" height=\"" + at(h) + "\"";
  return out.append(look).append("><title>").append(escaped(about)).append("</title></rect>\n");
}

std::string picture(std::string_view css_class, double w, double h, std::string_view title, std::string_view content) {
  std::string out = "<svg class=\"plot " + std::string(css_class) + "\" viewBox=\"0 0 " + at(w) + " " + at(h) +
                    "\" xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" aria-label=\"" + escaped(title) + "\">\n";
  return out.append(content).append("</svg>\n");
}

std::string key(std::string_view content, std::string_view name) {
  std::string out =
      "<li><svg class=\"plot key\" viewBox=\"0 0 24 18\" width=\"24\" height=\"18\" aria-hidden=\"true\">";
  return out.append(content).append("</svg>").append(escaped(name)).append("</li>\n");
}

std::string figure(std::string_view wide, std::string_view narrow, std::string_view keys) {
  std::string out = "<figure>\n";
  return out.append(wide).append(narrow).append("<ul class=\"legend\">\n").append(keys).append("</ul>\n</figure>\n");
}

}  // namespace assur::pictures::svg
