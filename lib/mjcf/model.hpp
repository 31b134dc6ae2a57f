// A model of MJCF: the tree of its bodies, the loops that close it, and its postures.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mjcf/document.hpp"

namespace assur::mjcf {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// Maps local coordinates to those around it: x -> at + turn x.
struct Frame {
  Vector3d at = Vector3d::Zero();
  Quaterniond turn = Quaterniond::Identity();

  [[nodiscard]] Vector3d operator*(const Vector3d& x) const { return at + turn * x; }
  [[nodiscard]] Frame operator*(const Frame& f) const { return {*this * f.at, (turn * f.turn).normalized()}; }
  [[nodiscard]] Frame inverse() const { return {-(turn.conjugate() * at), turn.conjugate()}; }
};

constexpr int kWorld = 0;
constexpr int kNone = -1;

struct Joint {
  enum class Kind { hinge, slide, ball, free };
  const Node* node = nullptr;
  std::string name;  // "" if it has none
  Kind kind = Kind::hinge;
  int body = kWorld;
  Vector3d at = Vector3d::Zero(), axis = Vector3d::UnitZ();  // in the frame of the body
  double reference = 0;                                      // its value in the posture of the model; rad or m
  std::optional<std::array<double, 2>> range;                // smallest and largest value of a hinge or slide; rad or m
  std::size_t first = 0;                                     // index of its first value in q

  [[nodiscard]] bool has_coordinate() const { return kind == Kind::hinge || kind == Kind::slide; }
  [[nodiscard]] std::size_t values() const { return kind == Kind::free ? 7 : kind == Kind::ball ? 4 : 1; }
  [[nodiscard]] int freedoms() const { return kind == Kind::free ? 6 : kind == Kind::ball ? 3 : 1; }
};

struct Body {
  const Node* node = nullptr;
  std::string name;
  int parent = kNone;
  Frame frame;              // in the frame of the parent, in the posture of the model
  std::vector<int> joints;  // to the parent, in order
};

struct Site {
  const Node* node = nullptr;
  std::string name;
  int body = kWorld;
  Frame frame;            // in the body
  bool has_frame = true;  // false: the frame is only a place
};

// A loop is closed by two frames that are one (weld) or have one origin (connect), or by joints that move together.
struct Loop {
  enum class Kind { connect, weld, joint };
  const Node* node = nullptr;
  std::string name;
  Kind kind = Kind::connect;
  int body1 = kWorld, body2 = kWorld;
  Frame frame1, frame2;                // in the bodies
  int joint1 = kNone, joint2 = kNone;  // joint1 - reference = offset + factor (joint2 - reference)
  double offset = 0, factor = 1;
};

struct Actuator {
  const Node* node = nullptr;
  std::string name;
  int joint = kNone;
};

struct Model {
  std::string name;
  std::vector<Body> bodies;  // the world first; parents before their children, as MuJoCo counts
  std::vector<Joint> joints;
  std::vector<Site> sites;
  std::vector<Loop> loops;
  std::vector<Actuator> actuators;                  // at most one for a joint
  std::map<std::string, std::vector<double>> keys;  // q
  std::map<std::string, std::size_t> left_out;
  std::size_t values = 0;  // of q

  // The first body on the way to the world that has joints, or the world: they move as one.
  [[nodiscard]] int mover(int body) const;
};

// name: used if the model has none. Throws Error (input) if something is wrong or not understood. The model refers to
// the document.
[[nodiscard]] Model read_model(const Document& document, const std::string& name);

// ---- postures

using Values = std::vector<double>;  // q: of all joints, as MuJoCo's qpos

// The posture of the model (qpos0).
[[nodiscard]] Values reference(const Model& model);

struct Posture {
  std::vector<Frame> bodies;            // in the world
  std::vector<Vector3d> anchors, axes;  // of joints, in the world
  std::vector<Quaterniond> turned;      // of the body of each joint, by this joint and those before it
};
[[nodiscard]] Posture posture(const Model& model, const Values& q);

// Moves q by the smallest motion that closes all loops to rounding. Returns the largest change of a joint in rad or m,
// and the joint. Throws Error (input) if a loop cannot be closed.
struct Change {
  double size = 0;
  int joint = kNone;
};
Change close(const Model& model, Values& q);

}  // namespace assur::mjcf
