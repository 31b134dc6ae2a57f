// Random mechanisms of bodies and joints: first the posture as written, then a unit of bodies after the other. They are
// written twice: with joints, and plainly, each body with a frame of its own and each joint as equal points and vectors
// and as lines. Their motion follows from the plain equations of the second scene.
#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "lettered_joint.hpp"
#include "mechanisms/plain_motion.hpp"
#include "properties/shipped.hpp"
#include "properties/small_random_scenes.hpp"

namespace assur::test {

// The motion of a coordinate of a joint or of a pose; 0 in the posture as written.
struct Curve {
  double amplitude = 0, frequency = 0.5, phase = 0, speed = 0, offset = 0;
  bool by_function = false;  // the law is a function of the program

  [[nodiscard]] Law law(double sign, double begin = 0) const;
};

constexpr int kNoUnit = -1;

class JointMechanism {
 public:
  // A body; its tracers are points whose motion is compared.
  struct Solid {
    std::string name;
    int unit = kNoUnit;
    std::vector<std::pair<std::string, Triple>> tracers = {};
    bool spins = false;      // free to turn about the line of its tracers, which other units must not see
    bool has_frame = false;  // its own origin and frame, for a driver of its pose
    std::string origin = {};
    std::vector<std::string> frame = {};
    Triple origin_at{};
  };
  struct Link {
    char letter;
    std::size_t a, b;
    Triple at{}, axis{}, second{};
    std::string name = {};
    int unit = kNoUnit;
    bool spins = false;  // a spherical joint that is written plainly as a universal one, so that a rod does not spin
  };

  JointMechanism(Draw& draw, int dimension);

  Draw& draw() { return draw_; }
  [[nodiscard]] double size() const { return size_; }
  [[nodiscard]] std::size_t solids() const { return solids_.size(); }
  [[nodiscard]] const Solid& solid(std::size_t s) const { return solids_[s]; }
  [[nodiscard]] const std::vector<std::string>& kinds() const { return kinds_; }  // of the units

  Triple spot() { return spot(origin_, size_); }
  Triple direction();
  Triple square_to(const Triple& axis);
  Curve swinging(double most);
  Curve angle();
  Curve shift() { return swinging(0.3 * size_); }

  std::size_t body();
  std::size_t rod(const Triple& middle);  // a body with one tracer
  std::size_t platform();
  // Either body may come first. Omitted directions are drawn.
  std::size_t connect(char letter, std::size_t a, std::size_t b, const Triple& at, const Triple& axis,
                      const Triple& second, bool spins = false);
  std::size_t connect(char letter, std::size_t a, std::size_t b, const Triple& at, const Triple& axis) {
    return connect(letter, a, b, at, axis, square_to(axis));
  }
  std::size_t connect(char letter, std::size_t a, std::size_t b, const Triple& at) {
    return connect(letter, a, b, at, direction());
  }
  // Drives the angle or the displacement of a joint, of body `b` relative to the other one.
  void drive(std::size_t joint, std::size_t b, bool is_angle, const Curve& curve) {
    motors_.push_back({joint, is_angle, links_[joint].b == b ? 1.0 : -1.0, curve});
  }
  void drive_pose(std::size_t solid);

  // Keeps the unit whose bodies and joints were added since the last call, if it is regular as written.
  bool keep(const std::string& kind);
  // Makes all motions smaller until no posture is close to a singular one. Keeps the rows of the motion.
  bool calm(const TimeGrid& grid);

  // With joints, in random order.
  [[nodiscard]] Scene write(const TimeGrid& grid);
  // Expects the motion of all tracers and measures. `scene` is the written one, whose bases bound how errors of
  // unknowns grow.
  void expect_motion(const Scene& scene) const;
  // True if no coordinate of a joint of this unit moves, because the bodies that it connects move as one.
  [[nodiscard]] bool rests(int unit) const;
  // Each group solves one unit. Returns the number of groups of each unit.
  [[nodiscard]] std::vector<int> groups_of_units(const GroupedSystem& s) const;

 private:
  using Jet = mechanisms::TimeJet<long double>;
  struct Motor {
    std::size_t joint;
    bool is_angle;
    double sign;
    Curve curve;
  };
  struct Posed {
    std::size_t solid;
    std::array<Curve, 6> curves;  // translation, rotation
  };

  [[nodiscard]] Triple spot(const Triple& centre, double reach);
  std::string fresh() { return std::string(1, static_cast<char>('a' + draw_.below(26))) + std::to_string(++names_); }
  [[nodiscard]] int units() const { return static_cast<int>(kinds_.size()); }
  [[nodiscard]] static bool has(const Link& j, bool is_angle) {
    return j.letter == 'C' || j.letter == (is_angle ? 'R' : 'P');
  }
  static std::string measure_of(const Link& j, bool is_angle) { return j.name + (is_angle ? "_angle" : "_way"); }
  [[nodiscard]] Pose pose(const Posed& p) const;
  [[nodiscard]] Scene plainly() const;
  void add_plainly(SceneBuilder& b, std::vector<Body>& bodies, const Link& j) const;
  [[nodiscard]] std::vector<Jet> laws_as_written() const;
  bool begin(mechanisms::PlainMotion& motion) const;
  bool follow(const TimeGrid& grid);
  [[nodiscard]] int unit_of(const std::string& unknown, const std::map<std::string, int>& bodies) const;

  Draw& draw_;
  int dimension_;
  double size_ = 1;
  Triple origin_{};
  std::vector<Solid> solids_;
  std::vector<Link> links_;
  std::vector<Motor> motors_;
  std::vector<Posed> poses_;
  std::vector<std::string> kinds_;
  std::array<std::size_t, 4> kept_{1, 0, 0, 0};
  std::map<std::string, int> drivers_;            // their units
  std::vector<std::map<std::string, Jet>> rows_;  // tracers by coordinate ("P.x"), and measures
  int names_ = 0;
};

}  // namespace assur::test
