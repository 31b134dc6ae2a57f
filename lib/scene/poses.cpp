#include "scene/poses.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <utility>

namespace assur {
namespace {

using Part = Orientation::Part;

constexpr std::string_view kGround = "ground";
constexpr std::pair<std::string_view, Part> kQuaternion[] = {
    {".qw", Part::w}, {".qx", Part::x}, {".qy", Part::y}, {".qz", Part::z}};
constexpr std::pair<std::string_view, Part> kTurn[] = {
    {".turn_x", Part::turn_x}, {".turn_y", Part::turn_y}, {".turn_z", Part::turn_z}};

// "B.origin.x" -> "B", "origin"; "B" -> "B", ""; "B..x" -> "B", ".", which is no part
std::pair<std::string_view, std::string_view> split(std::string_view text) {
  const std::size_t dot = text.find('.');
  if (dot == text.npos) return {text, ""};
  const std::string_view rest = text.substr(dot + 1);
  return {text.substr(0, dot), rest.empty() || rest[0] == '.' ? "." : rest.substr(0, rest.find('.'))};
}

bool is_pose(std::string_view part, int dimension) {
  if (part.empty() || part == "origin") return true;
  return dimension == 2 ? part == "angle"
                        : part == "quaternion" || part == "angular_velocity" || part == "angular_acceleration";
}

class Poses {
 public:
  explicit Poses(PoseParts parts) : p_(parts) {
    for (Body& b : p_.bodies) body_of_.emplace(b.name, &b);
  }

  std::vector<std::size_t> run() {
    std::vector<std::string> outputs;
    std::vector<std::size_t> written;
    for (std::size_t i = 0; i < p_.outputs.size(); ++i) {
      std::string& text = p_.outputs[i];
      const auto [name, part] = split(text);
      const auto found = body_of_.find(name);
      if (found == body_of_.end() || name == kGround || !is_pose(part, p_.dimension)) {
        outputs.push_back(std::move(text));
      } else {
        expand(*found->second, text, part, outputs);
      }
      written.resize(outputs.size(), i);
    }
    p_.outputs = std::move(outputs);
    return written;
  }

 private:
  void expand(Body& body, const std::string& text, std::string_view part, std::vector<std::string>& outputs) {
    const bool all = part.empty();
    if (all || part == "origin") {
      add(body.points, body, ".origin", {});
      outputs.push_back(all ? body.name + ".origin" : text);
    }
    if (part == "origin") return;
    add(body.vectors, body, ".ex", {1, 0, 0});
    if (p_.dimension == 2) {
      measure(body, ".angle", Part::angle);
      outputs.push_back(all ? body.name + ".angle" : text);
      return;
    }
    add(body.vectors, body, ".ey", {0, 1, 0});
    add(body.vectors, body, ".ez", {0, 0, 1});
    for (const auto& [name, which] : kQuaternion) {
      if (!all && part != "quaternion") break;
      measure(body, name, which);
      outputs.push_back(body.name + std::string(name) + ".value");
    }
    for (const auto& [wanted, derivative] :
         {std::pair("angular_velocity", ".rate"), std::pair("angular_acceleration", ".acceleration")}) {
      if (!all && part != wanted) continue;
      for (const auto& [name, which] : kTurn) {
        measure(body, name, which);
        outputs.push_back(body.name + std::string(name) + derivative);
      }
    }
  }

  void add(std::vector<Member>& members, const Body& body, std::string_view name, const Triple& at) {
    std::string full = body.name + std::string(name);
    if (!added_.insert(full).second) return;
    const bool has_frame = !body.origin.empty() || !body.base.empty() || !body.frame.empty();
    members.push_back({std::move(full), at, !has_frame});
  }

  void measure(const Body& body, std::string_view name, Part part) {
    std::string full = body.name + std::string(name);
    if (added_.insert(full).second) p_.measures.push_back({std::move(full), Orientation{body.name, part}});
  }

  PoseParts p_;
  std::unordered_map<std::string_view, Body*> body_of_;
  std::unordered_set<std::string> added_;  // names
};

}  // namespace

bool asks_for_pose(const std::vector<Body>& bodies, const std::vector<std::string>& outputs) {
  std::unordered_set<std::string_view> asked;
  for (const std::string& text : outputs) {
    const auto [name, part] = split(text);
    if (name != kGround && (is_pose(part, 2) || is_pose(part, 3))) asked.insert(name);
  }
  return std::any_of(bodies.begin(), bodies.end(), [&](const Body& b) { return asked.count(b.name) != 0; });
}

std::vector<std::size_t> expand_poses(PoseParts parts) {
  return asks_for_pose(parts.bodies, parts.outputs) ? Poses(parts).run() : std::vector<std::size_t>{};
}

}  // namespace assur
