#include "scene/axes.hpp"

#include <algorithm>
#include <utility>

#include "scene/names.hpp"
#include "scene/triple.hpp"

namespace assur {
namespace {

std::string made_name(const std::string& owner) { return owner + ".axis"; }

// The axis of a driver or measure; null if it has none.
template <class Item>
auto axis_in(Item& item) {
  return std::visit(
      [](auto& kind) -> std::conditional_t<std::is_const_v<Item>, const Anchor*, Anchor*> {
        if constexpr (requires { kind.axis; }) {
          return &kind.axis;
        } else {
          return nullptr;
        }
      },
      item.kind);
}

template <class Item>
bool is_made(const Item& item) {
  const Anchor* axis = axis_in(item);
  const std::string* name = axis == nullptr ? nullptr : std::get_if<std::string>(axis);
  return name != nullptr && *name == made_name(item.name);
}

template <class Item>
bool is_written(const Item& item) {
  const Anchor* axis = axis_in(item);
  return axis != nullptr && std::holds_alternative<Triple>(*axis);
}

template <class Item>
void expand(const AxisParts& parts, const Where& section, Item& item, std::vector<Diagnostic>& found) {
  if (!is_written(item)) return;
  Anchor& axis = *axis_in(item);
  const Triple at = std::get<Triple>(axis);
  axis = made_name(item.name);
  if (parts.dimension == 2) return;  // refused later
  const Number length = triple::norm(at);
  if (!triple::is_finite(at) || !(length > 0)) {
    found.push_back({(section / item.name / "axis").text(), "an axis needs finite numbers that are not all 0"});
    return;
  }
  parts.vectors.push_back({made_name(item.name), {at[0] / length, at[1] / length, at[2] / length}, true});
}

}  // namespace

bool has_made_axis(const Driver& driver) { return is_made(driver); }
bool has_made_axis(const Measure& measure) { return is_made(measure); }

bool has_written_axes(const AxisParts& parts) {
  const auto written = [](const auto& item) { return is_written(item); };
  return std::any_of(parts.drivers.begin(), parts.drivers.end(), written) ||
         std::any_of(parts.measures.begin(), parts.measures.end(), written);
}

std::vector<Diagnostic> expand_axes(const AxisParts& parts) {
  std::vector<Diagnostic> found;
  for (Driver& d : parts.drivers) expand(parts, Where("/drivers"), d, found);
  for (Measure& m : parts.measures) expand(parts, Where("/measures"), m, found);
  return found;
}

}  // namespace assur
