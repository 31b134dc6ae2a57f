#include "pictures/moving_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <utility>

#include "decimal.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "pictures/faces.hpp"
#include "pictures/html.hpp"
#include "pictures/moving_svg.hpp"
#include "pictures/view.hpp"

namespace assur::pictures {
namespace {

constexpr double kWidth = 760;                              // width of the picture, pixels
constexpr std::size_t kMostBytes = 60000;                   // small enough for a file in a repository
constexpr std::array kFrames = {48, 36, 24, 16, 10, 6, 1};  // numbers of frames to try; the first that fits is taken
constexpr double kShortest = 3, kLongest = 8;               // duration of the animation, s
constexpr std::size_t kMany = 150;                          // largest number of points with symbols
constexpr std::size_t kOfPath = 120;                        // largest number of points of a path
constexpr std::size_t kMostPaths = 40;
constexpr std::array<std::string_view, 6> kPalette = {"#0068a5", "#b36b00", "#00805d", "#b0508a", "#c44f00", "#5b5fc7"};

std::string colour(std::size_t i, std::size_t count) {
  if (count <= kPalette.size()) return std::string(kPalette[i]);
  const double golden = std::fmod(static_cast<double>(i) * 137.508 + 205, 360);  // far apart for neighbours
  return "hsl(" + fixed(golden, 0) + " 60% 40%)";
}

bool is_made(const std::string& name) { return name.find('.') != std::string::npos; }  // made by the program

// The places that the picture must show.
std::vector<Triple> seen(const Postures& p, std::size_t last) {
  std::vector<Triple> places;
  for (std::size_t f = 0; f <= last; f += last / 40 + 1) {
    for (std::size_t i = 0; i < p.drawing->points.size(); ++i) places.push_back(p.place(f, static_cast<int>(i)));
    for (const Drawing::Joint& j : p.drawing->joints) {
      if (!is_slider(j)) continue;
      const std::array<Triple, 2> ends = p.rail(j, f, last, 0);
      places.insert(places.end(), ends.begin(), ends.end());
    }
  }
  return places;
}

class Painter {
 public:
  // last: index of the last shown frame of the motion; frames: largest number of frames to draw.
  Painter(const Postures& p, const View& view, std::size_t last, bool repeats, std::size_t frames)
      : p_(p), d_(*p.drawing), view_(view), last_(last), svg_(cycle(p, view, last, repeats, frames)) {
    size_ = symbol_size();
    by_body_ = std::any_of(d_.joints.begin(), d_.joints.end(), [](const auto& j) { return !j.of.empty(); });
    for (std::size_t i = 0; i < d_.bodies.size(); ++i) {
      body_[d_.bodies[i].name] = by_body_ ? colour(i, d_.bodies.size()) : colour_of(d_.bodies[i].points);
    }
  }

  std::string paint(std::string_view title) {
    add_rails();
    add_paths();
    add_parts();
    const std::string w = pixels(kWidth), h = pixels(view_.height()), line = pixels(std::max(1.2, 0.28 * size_));
    const bool has_motors = std::any_of(d_.joints.begin(), d_.joints.end(), [](const auto& j) { return j.driven; });
    std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + w + " " + h + "\" width=\"" + w +
                      "\" height=\"" + h + "\" fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n";
    out += "<title>" + escaped(title) + "</title>\n<style>.j{fill:#fff;stroke:" + std::string(kInk) +
           ";stroke-width:" + line + "}" + (has_motors ? ".d{fill:" + std::string(kMotor) + "}" : "") +
           "</style>\n<rect width=\"" + w + "\" height=\"" + h + "\" rx=\"8\" fill=\"" + std::string(kPaper) + "\"/>\n";
    return out + svg_.text() + "</svg>\n";
  }

 private:
  static MovingSvg cycle(const Postures& p, const View& view, std::size_t last, bool repeats, std::size_t count) {
    if (count == 1 || last == 0) return {p, view, {0}, 0};
    std::vector<std::size_t> frames;
    const std::size_t way = repeats ? count : count / 2;
    for (std::size_t k = 0; k <= way; ++k) frames.push_back((last * k + way / 2) / way);
    if (repeats) frames.back() = 0;
    for (std::size_t k = way; k-- > 0 && !repeats;) frames.push_back(frames[k]);
    const double seconds = (p.times[last] - p.times[0]) * (repeats ? 1 : 2);
    return {p, view, std::move(frames), std::clamp(seconds, kShortest, kLongest)};
  }

  // The size of symbols: a share of the picture, but small beside typical links.
  [[nodiscard]] double symbol_size() const {
    std::vector<double> lengths;
    const auto add = [&](int a, int b) { lengths.push_back(distance(svg_.at(0, a), svg_.at(0, b))); };
    for (const Drawing::Link& l : d_.links) {
      if (!l.inside) add(l.from, l.to);
    }
    for (const Drawing::Body& b : d_.bodies) {
      for (std::size_t i = 1; i < b.points.size(); ++i) add(b.points[i - 1], b.points[i]);
    }
    std::sort(lengths.begin(), lengths.end());
    const double typical = lengths.empty() ? kInfinity : lengths[lengths.size() * 6 / 10];
    return std::max(3.5, std::min({7.0, 0.02 * view_.height(), 0.12 * typical}));
  }

  // The colour of the group that is solved last.
  [[nodiscard]] std::string colour_of(const std::vector<int>& points) const {
    int last = Drawing::Point::kFixed;
    for (const int i : points) last = std::max(last, d_.points[idx(i)].group);
    if (by_body_ || last < 0) return std::string(last == Drawing::Point::kFixed ? kFaint : kInk);
    return colour(idx(last), d_.groups.size());
  }

  void add_rails() {
    for (const Drawing::Joint& j : d_.joints) {
      if (!is_slider(j)) continue;
      const auto ends = [&](std::size_t f) {
        const std::array<Triple, 2> e = p_.rail(j, f, last_, 4 * size_ / view_.zoom());
        return std::vector<Pixel>{view_.at(e[0]), view_.at(e[1])};
      };
      if (p_.rests(j.axes[0]) && (j.origin < 0 || p_.rests(j.origin))) {
        std::vector<Pixel> e = ends(0);
        if (e[0][0] > e[1][0]) std::swap(e[0], e[1]);
        svg_.add(hatched(e[0], e[1], size_));
      } else {
        const auto body = j.of.empty() ? body_.end() : body_.find(j.of[0]);
        svg_.bar(ends, body == body_.end() ? std::string(kFaint) : body->second, 0.7 * size_);
      }
    }
  }

  void add_paths() {
    std::vector<int> all, asked;
    for (std::size_t i = 0; i < d_.moving; ++i) {
      const std::string& name = d_.points[i].name;
      if (is_made(name)) continue;
      all.push_back(static_cast<int>(i));
      const bool is_output = std::find(p_.outputs.begin(), p_.outputs.end(), name) != p_.outputs.end();
      if (is_output) asked.push_back(static_cast<int>(i));
    }
    const std::vector<int>& traced = asked.empty() ? all : asked;
    if (traced.size() > kMostPaths || last_ == 0) return;
    const std::size_t count = std::min(last_, kOfPath);
    for (const int i : traced) {
      std::vector<Pixel> path;
      for (std::size_t k = 0; k <= count; ++k) path.push_back(svg_.at(last_ * k / count, i));
      if (std::all_of(path.begin(), path.end(), [&](const Pixel& p) { return distance(p, path[0]) < 1; })) continue;
      svg_.add("<polyline points=\"" + pixels(path) + "\" stroke=\"" + colour_of({i}) +
               "\" stroke-opacity=\"0.6\" stroke-dasharray=\"2 4\"/>\n");
    }
  }

  // In space, far parts come first.
  void add_parts() {
    struct Part {
      double depth;
      std::function<void()> draw;
    };
    std::vector<Part> parts;
    const auto depth = [&](const std::vector<int>& points) {
      double sum = 0;
      for (const int i : points) sum += view_.depth(p_.place(0, i));
      return sum / static_cast<double>(points.size());
    };
    for (const Drawing::Body& b : d_.bodies) parts.push_back({depth(b.points), [&] { add_body(b); }});
    for (const Drawing::Link& l : d_.links) {
      if (!l.inside) parts.push_back({depth({l.from, l.to}), [&] { add_link(l); }});
    }
    const double before = 4 * size_ / view_.zoom();  // joints lie before the parts that meet in them
    std::set<int> jointed;
    for (const Drawing::Joint& j : d_.joints) {
      jointed.insert(j.point);
      if (d_.points.size() <= kMany) parts.push_back({depth({j.point}) + before, [&] { draw_joint(svg_, j, size_); }});
    }
    for (std::size_t i = 0; i < d_.moving && d_.points.size() <= kMany; ++i) {
      const int point = static_cast<int>(i);
      if (jointed.count(point) != 0 || is_made(d_.points[i].name)) continue;
      const std::string dot = "<circle r=\"" + pixels(0.6 * size_) + "\" fill=\"" + colour_of({point}) + "\"/>";
      parts.push_back({depth({point}) + before, [this, point, dot] { svg_.around(point, dot); }});
    }
    if (d_.dimension == 3) {
      std::stable_sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.depth < b.depth; });
    }
    for (const Part& p : parts) p.draw();
  }

  void add_body(const Drawing::Body& b) {
    std::vector<Triple> places;
    for (const int i : b.points) places.push_back(p_.place(0, i));
    const std::vector<std::vector<int>> all = faces(places);
    const std::string& colour = body_.at(b.name);
    const std::string look = "fill=\"" + colour + "\" fill-opacity=\"0.25\" stroke=\"" + colour + "\" stroke-width=\"" +
                             pixels((all.size() > 1 ? 0.3 : 0.7) * size_) + "\"";
    for (const std::vector<int>& face : all) {
      const auto corners = [&](std::size_t f) {
        std::vector<Pixel> path;
        for (const int i : face) path.push_back(svg_.at(f, b.points[idx(i)]));
        return path;
      };
      if (face.size() == 2) {
        svg_.bar(corners, colour, 1.1 * size_);
      } else {
        svg_.element(
            "polygon", "points", [&](std::size_t f) { return pixels(corners(f)); }, look);
      }
    }
  }

  void add_link(const Drawing::Link& l) {
    const std::string colour = by_body_ ? std::string(kFaint) : colour_of({l.from, l.to});
    const auto part = [&](double from, double to) {
      return [this, &l, from, to](std::size_t f) {
        const Pixel p = svg_.at(f, l.from), q = svg_.at(f, l.to);
        return std::vector<Pixel>{between(p, q, from), between(p, q, to)};
      };
    };
    if (l.kind == Drawing::Kind::rod) return svg_.bar(part(0, 1), colour, 0.9 * size_);
    if (l.kind == Drawing::Kind::relation) {
      return svg_.element(
          "polyline", "points", [&](std::size_t f) { return pixels(part(0, 1)(f)); },
          "stroke=\"" + colour + "\" stroke-dasharray=\"2 4\"");
    }
    svg_.bar(part(0, 1), colour, 0.5 * size_);  // a thin rod that leaves a cylinder
    svg_.bar(part(0.08, 0.55), colour, 1.7 * size_);
    svg_.element(
        "polyline", "points", [&](std::size_t f) { return pixels(part(0.08, 0.55)(f)); },
        "stroke=\"" + std::string(kPaper) + "\" stroke-width=\"" + pixels(0.8 * size_) + "\"");
  }

  const Postures& p_;
  const Drawing& d_;
  const View& view_;
  std::size_t last_;
  MovingSvg svg_;
  double size_ = 5;  // size of symbols, pixels
  bool by_body_ = false;
  std::map<std::string, std::string> body_;  // colours of bodies
};

}  // namespace

std::string moving_picture(const Postures& postures, std::string_view title) {
  const std::size_t period = postures.period(), last = period > 0 ? period : postures.frames() - 1;
  const View view(postures.drawing->dimension, seen(postures, last), kWidth);
  std::string svg;
  for (const int frames : kFrames) {
    svg = Painter(postures, view, last, period > 0, static_cast<std::size_t>(frames)).paint(title);
    if (svg.size() <= kMostBytes) break;
  }
  return svg;
}

}  // namespace assur::pictures
