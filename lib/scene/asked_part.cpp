#include "scene/asked_part.hpp"

namespace assur {

std::optional<AskedPart> asked_part(std::string_view part, int components) {
  static constexpr std::string_view kScalar[3] = {"value", "rate", "acceleration"};
  static constexpr std::string_view kWhole[3] = {"position", "velocity", "acceleration"};
  for (int d = 0; d < 3; ++d) {
    if (part == (components == 1 ? kScalar : kWhole)[d]) return AskedPart{-1, d};
  }
  if (components == 1 || part.empty()) return {};
  const int derivative = part.size() == 1 ? 0 : part[0] == 'v' ? 1 : part[0] == 'a' ? 2 : -1;
  const int component = part.back() - 'x';
  if (part.size() > 2 || derivative < 0 || component < 0 || component >= components) return {};
  return AskedPart{component, derivative};
}

}  // namespace assur
