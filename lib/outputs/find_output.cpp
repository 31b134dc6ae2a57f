#include <algorithm>
#include <initializer_list>

#include "assur/rows.hpp"
#include "assur/status.hpp"
#include "outputs/columns.hpp"

namespace assur {
namespace {

constexpr std::size_t kNone = OutputHandle::kNone;

std::size_t place_of(const std::vector<std::string>& columns, const std::string& name) {
  const auto found = std::find(columns.begin(), columns.end(), name);
  return found == columns.end() ? kNone : static_cast<std::size_t>(found - columns.begin());
}

// The columns prefix + ends[0], prefix + ends[1], ..., which follow each other, as a d-th derivative. False if the
// first one is missing. Throws as find_output() does if only others are missing.
bool find_row(const std::vector<std::string>& columns, const std::string& prefix,
              std::initializer_list<const char*> ends, std::size_t d, OutputHandle& out) {
  const std::size_t first = place_of(columns, prefix + *ends.begin());
  if (first == kNone) return false;
  std::size_t i = first;
  for (const char* end : ends) {
    if (i >= columns.size() || columns[i] != prefix + end) (void)column_index(columns, prefix + end);
    ++i;
  }
  out.components = ends.size();
  out.first[d] = first;
  return true;
}

}  // namespace

OutputHandle find_output(const std::vector<std::string>& columns, std::string_view output) {
  const std::string name(output);
  const auto of_body = [&](std::string_view part) { return name.substr(0, name.size() - part.size()); };
  OutputHandle out;
  bool found = false;
  if (output.ends_with(".quaternion")) {
    found = find_row(columns, of_body("quaternion"), {"qw", "qx", "qy", "qz"}, 0, out);
  } else if (output.ends_with(".angular_velocity")) {
    found = find_row(columns, of_body("angular_velocity"), {"wx", "wy", "wz"}, 1, out);
    if (find_row(columns, of_body("angular_velocity"), {"alphax", "alphay", "alphaz"}, 2, out)) found = true;
  } else {
    static constexpr const char* kScalar[3] = {"", ".rate", ".acceleration"};
    static constexpr const char* kVector[3] = {".", ".v", ".a"};
    for (std::size_t d = 0; d < 3; ++d) {
      const std::string in_space = name + kVector[d];
      if (place_of(columns, in_space + "z") != kNone) {
        found = find_row(columns, in_space, {"x", "y", "z"}, d, out) || found;
      } else if (find_row(columns, name + kScalar[d], {""}, d, out) ||
                 find_row(columns, in_space, {"x", "y"}, d, out)) {
        found = true;
      }
    }
  }
  if (!found) (void)column_index(columns, name);  // throws
  return out;
}

BodyHandle find_body(const std::vector<std::string>& columns, std::string_view body) {
  const std::string name(body);
  BodyHandle out;
  out.origin = find_output(columns, name + ".origin");
  if (out.origin.components == 2) {
    out.turn = find_output(columns, name + ".angle");
  } else {
    out.quaternion = find_output(columns, name + ".quaternion");
    out.turn = find_output(columns, name + ".angular_velocity");
  }
  const std::size_t rotation = (out.origin.components == 2 ? out.turn : out.quaternion).first[0];
  if (out.origin.first[0] == kNone || rotation == kNone) {
    throw Error(Error::Kind::input,
                "the columns have not the whole pose of '" + name + "': name the body as an output");
  }
  return out;
}

}  // namespace assur
