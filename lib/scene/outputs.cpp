#include "scene/outputs.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <unordered_map>

namespace assur {
namespace {

Output of_item(const Item& item) {
  Output out;
  out.name = item.name;
  out.part_count = static_cast<std::size_t>(item.components);
  for (std::size_t k = 0; k < out.part_count; ++k) {
    out.all_parts[k] = {MeasureForms::Kind::form, {&item.form[k], 1}, item.dimension};
  }
  return out;
}

Output of_measure(const MeasureForms& measure) {
  Output out;
  out.name = measure.name;
  out.all_parts[0] = {measure.kind, measure.forms, measure.dimension};
  return out;
}

// A column stands once, where it is first asked for.
void drop_repeated(std::vector<Output>& outputs) {
  std::unordered_map<std::string_view, std::array<bool, 3>> taken;
  for (Output& o : outputs) {
    auto& before = taken[o.name];
    for (std::size_t d = 0; d < 3; ++d) {
      o.wanted[d] = o.wanted[d] && !before[d];
      before[d] = before[d] || o.wanted[d];
    }
  }
  std::erase_if(outputs, [](const Output& o) { return std::none_of(o.wanted, o.wanted + 3, std::identity{}); });
}

}  // namespace

std::vector<Output> wanted_outputs(const System& s) {
  std::vector<Output> out;
  if (s.outputs.empty()) {
    for (const Item& item : s.items) {
      if (!item.hidden && !item.fixed) out.push_back(of_item(item));
    }
    for (const MeasureForms& m : s.measures) out.push_back(of_measure(m));
    return out;
  }
  std::unordered_map<std::string_view, const MeasureForms*> measure;
  for (const MeasureForms& m : s.measures) measure.emplace(m.name, &m);
  for (const std::string& text : s.outputs) {
    const auto find = [&](const std::string& name) -> bool {
      if (const auto m = measure.find(name); m != measure.end()) {
        out.push_back(of_measure(*m->second));
        return true;
      }
      if (const auto i = s.item_of.find(name); i != s.item_of.end()) {
        out.push_back(of_item(s.items[static_cast<std::size_t>(i->second)]));
        return true;
      }
      return false;
    };
    if (find(text)) continue;
    const std::size_t dot = text.rfind('.');
    if (dot == std::string::npos || !find(text.substr(0, dot))) {
      throw Error(Error::Kind::input, {{"/outputs", "'" + text + "' is no point, vector, scalar or measure"}});
    }
    const std::string part = text.substr(dot + 1);
    const int d = part == "position" || part == "value" ? 0 : part == "velocity" || part == "rate" ? 1 : 2;
    for (int k = 0; k < 3; ++k) out.back().wanted[k] = k == d;
  }
  drop_repeated(out);
  return out;
}

void append_columns(const Output& o, std::vector<std::string>& columns) {
  static constexpr const char* kScalar[3] = {"", ".rate", ".acceleration"};
  static constexpr const char* kVector[3] = {".", ".v", ".a"};
  for (int d = 0; d < 3; ++d) {
    if (!o.wanted[d]) continue;
    if (o.part_count == 1) {
      columns.push_back(std::string(o.name) + kScalar[d]);
    } else {
      for (std::size_t k = 0; k < o.part_count; ++k) columns.push_back(std::string(o.name) + kVector[d] + "xyz"[k]);
    }
  }
}

std::vector<std::string> column_names(const System& system) {
  std::vector<std::string> names;
  for (const Output& o : wanted_outputs(system)) append_columns(o, names);
  return names;
}

}  // namespace assur
