#include "mechanisms/draft.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace assur::mechanisms {

double norm(const Place& a) { return std::sqrt(dot(a, a)); }
Place turned(const Place& v, const Place& axis, double angle) {  // Rodrigues
  return std::cos(angle) * v + std::sin(angle) * cross(axis, v) + (1 - std::cos(angle)) * dot(axis, v) * axis;
}

Draft::Draft(int d, Draw& c, std::string tables) : chance(c), dimension(d), tables_(std::move(tables)) {
  json_["assur"] = 1;
  json_["name"] = "";
  json_["dimension"] = dimension;
  for (const char* section : {"points", "vectors", "bodies", "constraints", "drivers", "measures"}) {
    json_[section] = Json::object();
  }
  // Half of the mechanisms are not rotated.
  rotation_ = {Place{1, 0, 0}, Place{0, 1, 0}, Place{0, 0, 1}};
  turned_ = chance.one_in(2);
  if (turned_) {
    const Place axis = dimension == 3 ? chance.direction() : Place{0, 0, 1};
    const double angle = chance.real(-3, 3);
    for (Place& a : rotation_) a = mechanisms::turned(a, axis, angle);
  }
  if (chance.one_in(3)) scale_ = std::pow(10, chance.real(-3, 3));
  if (chance.one_in(8)) {
    shift_ = scale_ * std::pow(10, chance.real(2, 5)) * chance.direction(dimension);
  }
  if (chance.one_in(4)) begin_ = chance.real(-5, 5);
  speed = std::pow(10, chance.real(-0.7, 0.8));
  const double span = chance.real(0.3, 2.5);
  const auto steps = static_cast<int>(chance.one_in(3) ? 3 + chance.below(8) : 10 + chance.below(60));
  const double step = span / steps;
  end_ = begin_ + steps * step;
  json_["time"] = {{"start", begin_}, {"end", end_}, {"step", step}};
  if (chance.one_in(2)) rough = chance.real(10, 120) * std::numbers::pi / 180;
}

Place Draft::written(const Drawn& part) const {
  Place p{};
  for (int k = 0; k < 3; ++k) p = p + part.place[k] * rotation_[static_cast<std::size_t>(k)];
  return part.is_point ? scale_ * p + shift_ : p;
}

Json Draft::numbers(const Place& p) const { return dimension == 3 ? Json{p[0], p[1], p[2]} : Json{p[0], p[1]}; }

Json Draft::name_of(const Way& d) const { return d.second.empty() ? Json(d.first) : Json{d.first, d.second}; }

std::string Draft::next(const char* kind) { return kind + std::to_string(count_[kind]++); }

void Draft::constrain(Json constraint) { json_["constraints"][next("c")] = std::move(constraint); }

void Draft::put(const std::string& name, const Place& at, bool is_point, bool fixed) {
  at_[name] = {at, is_point, fixed};
  order_.push_back(name);
}

Place Draft::along(const Way& d) const { return d.second.empty() ? at(d.first) : at(d.second) - at(d.first); }

void Draft::together(const std::vector<std::string>& names) {
  const int cluster = count_["cluster"]++;
  for (const std::string& name : names) {
    if (cluster_.count(name) == 0) cluster_[name] = cluster;
  }
}

void Draft::members(Json& body, const Place& origin, const std::array<Place, 3>& axes,
                    const std::map<std::string, Place>& points, const std::map<std::string, Place>& vectors) {
  const auto local = [&](const Place& v) { return Place{dot(v, axes[0]), dot(v, axes[1]), dot(v, axes[2])}; };
  for (const auto& [name, place] : points) {
    at_[name] = {place, true, false};
    body["points"][name] = numbers(scale_ * local(place - origin));
  }
  for (const auto& [name, place] : vectors) {
    at_[name] = {place, false, false};
    body["vectors"][name] = numbers(local(place));
  }
}

void Draft::frame_body(const std::string& name, const std::string& origin, const std::vector<std::string>& frame,
                       const std::map<std::string, Place>& points, const std::map<std::string, Place>& vectors) {
  Json body = {{"origin", origin}, {"frame", frame}};
  const Place u = at(frame[0]);
  std::array<Place, 3> axes = {u, {-u[1], u[0], 0}, {0, 0, 1}};
  if (frame.size() == 3) axes = {u, at(frame[1]), at(frame[2])};
  together(frame);
  members(body, at(origin), axes, points, vectors);
  json_["bodies"][name] = std::move(body);
}

void Draft::base_body(const std::string& name, const std::vector<std::string>& base,
                      const std::map<std::string, Place>& points, const std::map<std::string, Place>& vectors) {
  Json body = {{"base", base}};
  const Place x = unit(at(base[1]) - at(base[0]));
  std::array<Place, 3> axes = {x, {-x[1], x[0], 0}, {0, 0, 1}};
  if (base.size() == 3) {
    const Place z = unit(cross(x, at(base[2]) - at(base[0])));
    axes = {x, cross(z, x), z};
  }
  together(base);
  members(body, at(base[0]), axes, points, vectors);
  json_["bodies"][name] = std::move(body);
  // With rough guesses, all lengths are written out.
  for (std::size_t i = 0; i < base.size(); ++i) {
    for (std::size_t j = i + 1; j < base.size(); ++j) {
      if (rough > 0 || chance.one_in(3)) distance(base[i], base[j]);
    }
  }
}

void Draft::shifted_body(const std::string& name, const std::string& origin,
                         const std::map<std::string, Place>& points) {
  Json body = {{"origin", origin}};
  std::array<Place, 3> axes = {Place{rotation_[0][0], rotation_[1][0], rotation_[2][0]},
                               Place{rotation_[0][1], rotation_[1][1], rotation_[2][1]},
                               Place{rotation_[0][2], rotation_[1][2], rotation_[2][2]}};
  members(body, at(origin), axes, points, {});
  json_["bodies"][name] = std::move(body);
}

void Draft::distance(const std::string& p, const std::string& q) {
  for (const auto& [name, c] : json_["constraints"].items()) {
    if (c.contains("distance") && (c["distance"] == Json{p, q} || c["distance"] == Json{q, p})) return;
  }
  Json c = {{"distance", {p, q}}};
  if (rough > 0 || chance.one_in(2)) c["value"] = scale_ * norm(at(p) - at(q));
  constrain(std::move(c));
}

void Draft::equal_distance(const std::string& p, const std::string& q, const std::string& r, const std::string& s) {
  constrain({{"equal_distance", Json::array({Json{p, q}, Json{r, s}})}});
}

void Draft::dot_product(const Way& d, const Way& e) {
  double value = dot(along(d), along(e));
  // Right angles have the value 0, or cos(pi / 2) in doubles.
  if (std::abs(value) < 1e-12) value = chance.one_in(4) ? 6.123233995736766e-17 : 0;
  if (is_length(d)) value *= scale_;
  if (is_length(e)) value *= scale_;
  Json c = {{"dot", Json::array({name_of(d), name_of(e)})}};
  if (rough > 0 || value == 0 || std::abs(value) < 1e-12 || chance.one_in(2)) c["value"] = value;
  constrain(std::move(c));
}

void Draft::parallel(const Way& d, const Way& e) { constrain({{"parallel", Json::array({name_of(d), name_of(e)})}}); }

std::string Draft::on_line(const std::string& p, const std::string& a, const Way& d) {
  const std::string name = next("line");
  json_["constraints"][name] = {{"on_line", {p, a, name_of(d)}}};
  return name;
}

std::string Draft::on_plane(const std::string& p, const std::string& a, const Way& d, const Way& e) {
  const std::string name = next("plane");
  json_["constraints"][name] = {{"on_plane", {p, a, name_of(d), name_of(e)}}};
  return name;
}

void Draft::level(const std::string& point, int component) {
  constrain({{"coordinate", point + "." + "xyz"[component]}, {"value", written(at_.at(point))[component]}});
}

void Draft::constraint_equal(const std::string& p, const std::string& q) {
  constrain({{"linear", Json::array({Json{p, 1}, Json{q, -1}})}});
}

void Draft::middle(const std::string& m, const std::string& p, const std::string& q) {
  constrain({{"linear", Json::array({Json{m, 2}, Json{p, -1}, Json{q, -1}})}});
}

// A law that starts at `begin` and changes by about `by` over the whole time.
Json Draft::law(double begin, double by) {
  const double span = end_ - begin_, rate = by / span;
  const auto line = [&](double b, double r) { return Json{{"polynomial", Json{b - r * begin_, r}}}; };
  const auto swing = [&](double b, double amplitude) {
    const double f = chance.real(0.2, 1) / span, phase = chance.real(0, 6.2);
    const double now = amplitude * std::sin(2 * std::numbers::pi * f * begin_ + phase);
    const Json term = {{"amplitude", amplitude}, {"frequency", f}, {"phase", phase}};
    return Json{{"harmonics", Json::array({term})}, {"offset", b - now}};
  };
  switch (chance.below(6)) {
    case 0: {
      const double c = chance.real(-0.5, 0.5) * rate / span;  // r (t - t0) + c (t - t0)^2
      return {{"polynomial", {begin - rate * begin_ + c * begin_ * begin_, rate - 2 * c * begin_, c}}};
    }
    case 1:
      return swing(begin, by / 2);
    case 2:
      return Json::array({Json{{"constant", begin}}, swing(0, by / 3), line(0, rate / 2)});
    case 3:
      if (!tables_.empty() && begin_ == 0 && std::abs(by) > 0.3 && std::abs(by) < 3) {
        return Json::array({Json{{"constant", begin}}, Json{{"table", "swing.csv"}}});
      }
      return line(begin, rate);
    default:
      return line(begin, rate);
  }
}

std::string Draft::turn(const std::string& a, const std::string& b, const std::string& axis) {
  const std::string name = next("motor");
  const double by = chance.sign() * speed * (end_ - begin_);
  Json driver = {{"angle", {a, b}}};
  double begin = 0;
  if (dimension == 2) {
    const Place d = written(at_.at(b)) - written(at_.at(a));
    begin = std::atan2(d[1], d[0]);
  } else {
    driver["axis"] = axis;
    exact(a), exact(b);  // the driver measures its angle from this guess
  }
  driver["law"] = law(begin, by);
  json_["drivers"][name] = std::move(driver);
  driven_.push_back({name, begin, by});
  return name;
}

std::string Draft::turn_between(const Way& d, const Way& e, const std::string& axis) {
  const std::string name = next("motor");
  const double by = chance.sign() * speed * (end_ - begin_);
  const Place x = along(d), y = along(e), both = cross(x, y);
  const double begin = std::atan2(dimension == 2 ? both[2] : dot(at(axis), both), dot(x, y));
  Json driver = {{"angle", Json::array({name_of(d), name_of(e)})}};
  if (dimension == 3) driver["axis"] = axis;
  driver["law"] = law(begin, by);
  json_["drivers"][name] = std::move(driver);
  driven_.push_back({name, begin, by});
  return name;
}

std::string Draft::reach(const std::string& a, const std::string& b, double by) {
  const std::string name = next("cylinder");
  const double begin = scale_ * norm(at(a) - at(b));
  json_["drivers"][name] = {{"distance", {a, b}}, {"law", law(begin, scale_ * by)}};
  driven_.push_back({name, begin, scale_ * by});
  return name;
}

std::string Draft::slide(const std::string& coordinate, double begin, double by, bool length) {
  const std::string name = next("slide");
  const double unit = length ? scale_ : 1;
  json_["drivers"][name] = {{"coordinate", coordinate}, {"law", law(unit * begin, unit * by)}};
  driven_.push_back({name, unit * begin, unit * by});
  return name;
}

std::string Draft::move(const std::string& point, int component, double by) {
  const std::string name = next("slide");
  const double begin = written(at_.at(point))[component];
  json_["drivers"][name] = {{"coordinate", point + "." + "xyz"[component]}, {"law", law(begin, scale_ * by)}};
  driven_.push_back({name, begin, scale_ * by});
  return name;
}

// The frame of the body is parallel to the axes of the ground, see keep_axes().
void Draft::pose(const std::string& body, const std::string& origin, double shift, double angle) {
  Json translation = Json::array(), rotation = Json::array();
  const Place o = written(at_.at(origin));
  for (int k = 0; k < dimension; ++k) {
    translation.push_back(law(o[k], scale_ * shift * chance.real(-1, 1)));
  }
  json_["drivers"]["pose"] = {{"pose", body}, {"translation", translation}};
  if (angle == 0) return;
  if (dimension == 2) {
    json_["drivers"]["pose"]["rotation"] = {{"angle", law(0, angle * chance.real(-1, 1))}};
    return;
  }
  for (int k = 0; k < 3; ++k) rotation.push_back(law(0, angle * chance.real(-1, 1)));
  json_["drivers"]["pose"]["rotation"] = {{"euler_zyx", rotation}};
}

void Draft::measure_angle(const std::string& a, const std::string& b) {
  json_["measures"][next("m")] = {{"angle", {a, b}}};
}
void Draft::measure_between(const Way& d, const Way& e, const std::string& axis) {
  Json m = {{"angle", Json::array({name_of(d), name_of(e)})}};
  if (!axis.empty()) m["axis"] = axis;
  json_["measures"][next("m")] = std::move(m);
}
void Draft::measure_distance(const std::string& a, const std::string& b) {
  json_["measures"][next("m")] = {{"distance", {a, b}}};
}
void Draft::measure_coordinate(const std::string& coordinate) {
  json_["measures"][next("m")] = {{"coordinate", coordinate}};
}

std::string Draft::finish(const std::string& name, double off) {
  json_["name"] = name;
  std::map<int, std::pair<Place, double>> turns;
  double size = 0;
  int points = 0;
  Place centre{};
  for (const std::string& part : order_) {
    if (!at_[part].is_point) continue;
    centre = centre + at_[part].place, ++points;
  }
  for (const std::string& part : order_) {
    if (at_[part].is_point) size = std::max(size, norm(at_[part].place - 1.0 / points * centre));
  }
  for (const std::string& part : order_) {
    Drawn p = at_[part];
    if (!p.fixed && off > 0 && exact_.count(part) == 0) {
      if (p.is_point) {
        const double most = 0.3 * size * off / (2 * std::numbers::pi / 3);
        p.place = p.place + chance.real(0, most) * chance.direction(dimension);
      } else {
        const int cluster = cluster_.count(part) != 0 ? cluster_[part] : -1;
        auto turn = std::pair(dimension == 3 ? chance.direction() : Place{0, 0, 1}, chance.real(-off, off));
        if (cluster >= 0) turn = turns.emplace(cluster, turn).first->second;
        p.place = mechanisms::turned(p.place, turn.first, turn.second);
      }
    }
    Json at = {{"at", numbers(written(p))}};
    if (p.fixed) at["fixed"] = true;
    json_[p.is_point ? "points" : "vectors"][part] = std::move(at);
  }
  Json written_down = json_;
  for (const char* section : {"vectors", "bodies", "measures"}) {
    if (written_down[section].empty()) written_down.erase(section);
  }
  return written_down.dump();
}

}  // namespace assur::mechanisms
