// A random scene under construction: a posture that satisfies all equations. It is written in the scene format,
// rotated, scaled and shifted as a whole, with guesses near the posture.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "mechanisms/draw.hpp"

namespace assur::mechanisms {

using Json = nlohmann::ordered_json;
using Place = Spatial<double>;

double norm(const Place& a);
Place turned(const Place& v, const Place& axis, double angle);  // axis of length 1

// A vector's name, or two points.
struct Way {
  std::string first, second;
  Way(const char* vector) : first(vector) {}             // NOLINT
  Way(std::string vector) : first(std::move(vector)) {}  // NOLINT
  Way(std::string a, std::string b) : first(std::move(a)), second(std::move(b)) {}
};

class Draft {
 public:
  Draft(int dimension, Draw& chance, std::string tables);

  Draw& chance;
  const int dimension;
  // Speed of the drivers, rad/s.
  double speed = 1;

  // Parts in the posture, before rotation and scaling.
  void fixed(const std::string& name, const Place& at) { put(name, at, true, true); }
  void point(const std::string& name, const Place& at) { put(name, at, true, false); }
  void fixed_vector(const std::string& name, const Place& at) { put(name, at, false, true); }
  void vector(const std::string& name, const Place& at) { put(name, at, false, false); }
  // Rough guesses of these parts are rotated together.
  void together(const std::vector<std::string>& names);
  // The guess of this part is exact, because an angle of a driver begins there.
  void exact(const std::string& name) { exact_[name] = true; }

  // A body with a frame (3 vectors in space, 1 in the plane), a base, or an origin alone. Members are given in the
  // posture.
  void frame_body(const std::string& name, const std::string& origin, const std::vector<std::string>& frame,
                  const std::map<std::string, Place>& points, const std::map<std::string, Place>& vectors = {});
  void base_body(const std::string& name, const std::vector<std::string>& base,
                 const std::map<std::string, Place>& points, const std::map<std::string, Place>& vectors = {});
  void shifted_body(const std::string& name, const std::string& origin, const std::map<std::string, Place>& points);

  void distance(const std::string& p, const std::string& q);
  void equal_distance(const std::string& p, const std::string& q, const std::string& r, const std::string& s);
  void dot_product(const Way& d, const Way& e);
  void parallel(const Way& d, const Way& e);
  std::string on_line(const std::string& p, const std::string& a, const Way& d);  // returns its name
  std::string on_plane(const std::string& p, const std::string& a, const Way& d, const Way& e);
  void level(const std::string& point, int component);                            // fixes one coordinate in the ground
  void constraint_equal(const std::string& p, const std::string& q);              // equal positions, by `linear`
  void middle(const std::string& m, const std::string& p, const std::string& q);  // m = (p + q) / 2, by `linear`

  // Drivers begin in the posture and follow a random law.
  std::string turn(const std::string& a, const std::string& b, const std::string& axis = "");  // angle of a point
  std::string turn_between(const Way& d, const Way& e, const std::string& axis = "");
  std::string reach(const std::string& a, const std::string& b, double by);  // a distance, changed by this much
  std::string slide(const std::string& coordinate, double begin, double by, bool length = true);
  std::string move(const std::string& point, int component, double by);
  void pose(const std::string& body, const std::string& origin, double shift, double angle);

  void measure_angle(const std::string& a, const std::string& b);  // in the plane
  void measure_between(const Way& d, const Way& e, const std::string& axis = "");
  void measure_distance(const std::string& a, const std::string& b);
  void measure_coordinate(const std::string& coordinate);

  [[nodiscard]] const Place& at(const std::string& name) const { return at_.at(name).place; }
  [[nodiscard]] Place along(const Way& d) const;

  // The JSON of the scene. off: error of the guesses, rad; lengths are wrong in proportion.
  [[nodiscard]] std::string finish(const std::string& name, double off);
  // Drivers that a program may set, with their start values and ranges.
  struct Driven {
    std::string name;
    double begin, by;
  };
  [[nodiscard]] const std::vector<Driven>& driven() const { return driven_; }
  [[nodiscard]] bool turned_as_a_whole() const { return turned_; }
  void keep_axes() { rotation_ = {Place{1, 0, 0}, Place{0, 1, 0}, Place{0, 0, 1}}, turned_ = false; }
  double rough = 0;  // error of the guesses; if not 0, all values are written out

 private:
  struct Drawn {
    Place place;
    bool is_point, fixed;
  };
  void put(const std::string& name, const Place& at, bool is_point, bool fixed);
  [[nodiscard]] Place written(const Drawn& part) const;  // rotated, scaled and shifted
  [[nodiscard]] Json numbers(const Place& p) const;
  [[nodiscard]] Json name_of(const Way& d) const;
  [[nodiscard]] bool is_length(const Way& d) const { return !d.second.empty(); }
  Json law(double begin, double by);
  std::string next(const char* kind);
  void constrain(Json constraint);
  void members(Json& body, const Place& origin, const std::array<Place, 3>& axes,
               const std::map<std::string, Place>& points, const std::map<std::string, Place>& vectors);

  std::string tables_;
  Json json_;
  std::map<std::string, Drawn> at_;
  std::vector<std::string> order_;
  std::map<std::string, int> cluster_;
  std::map<std::string, bool> exact_;
  std::vector<Driven> driven_;
  std::array<Place, 3> rotation_;
  bool turned_ = true;
  double scale_ = 1;
  Place shift_{};
  double begin_ = 0, end_ = 1;
  std::map<std::string, int> count_;
};

}  // namespace assur::mechanisms
