#include "equations/outputs.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <unordered_map>
#include <utility>

#include "scene/asked_part.hpp"

namespace assur {
namespace {

Output of_item(const Item& item) {
  Output out;
  out.name = item.name;
  out.part_count = static_cast<std::size_t>(item.components);
  for (std::size_t k = 0; k < out.part_count; ++k) {
    out.all_parts[k] = {MeasureForms::Kind::form, item.dimension, {&item.form[k], 1}};
  }
  return out;
}

Output of_measure(const MeasureForms& measure) {
  Output out;
  out.name = measure.name;
  out.all_parts[0] = {measure.kind, measure.dimension, measure.forms};
  if (measure.is_sum()) out.sum = &measure;
  out.wanted[0] = !is_turn(measure.kind);
  return out;
}

// Puts the terms of sums before the sums.
std::vector<Output> with_terms(const System& s, std::vector<Output> outputs) {
  if (std::none_of(outputs.begin(), outputs.end(), [](const Output& o) { return o.sum != nullptr; })) return outputs;
  std::vector<Output> out;
  for (const Output& o : outputs) {
    for (std::size_t i = 0; o.sum != nullptr && i < o.sum->terms.size(); ++i) {
      out.push_back(of_measure(s.measures[static_cast<std::size_t>(o.sum->terms[i].measure)]));
      std::copy_n(o.wanted, 3, out.back().wanted);
    }
    out.push_back(o);
  }
  return out;
}

// One component of one derivative: a single column.
Output column_of(const Output& output, std::size_t component, std::size_t derivative) {
  Output out = output;
  out.component = static_cast<int>(component);
  out.all_parts[0] = output.all_parts[component];
  out.part_count = 1;
  for (std::size_t d = 0; d < 3; ++d) out.wanted[d] = d == derivative;
  return out;
}

// Each column appears once, where it is first requested. Of an output that was partly requested before, the other
// columns remain.
std::vector<Output> without_repetition(const std::vector<Output>& outputs) {
  std::unordered_map<std::string_view, std::array<std::array<bool, 3>, 3>> taken;  // [derivative][component]
  std::vector<Output> out;
  for (Output o : outputs) {
    auto& before = taken[o.name];
    const std::size_t first = o.component < 0 ? 0 : static_cast<std::size_t>(o.component);
    bool is_cut = false;
    for (std::size_t d = 0; d < 3; ++d) {
      const auto begin = before[d].begin() + static_cast<std::ptrdiff_t>(first);
      const auto count = std::count(begin, begin + static_cast<std::ptrdiff_t>(o.part_count), true);
      if (count == static_cast<std::ptrdiff_t>(o.part_count)) o.wanted[d] = false;
      is_cut = is_cut || (o.wanted[d] && count > 0);
    }
    if (!is_cut && std::any_of(o.wanted, o.wanted + 3, std::identity{})) out.push_back(o);
    for (std::size_t d = 0; d < 3; ++d) {
      for (std::size_t k = first; o.wanted[d] && k < first + o.part_count; ++k) {
        if (is_cut && !before[d][k]) out.push_back(column_of(o, k, d));
        before[d][k] = true;
      }
    }
  }
  return out;
}

}  // namespace

std::vector<Output> wanted_outputs(const System& s) {
  std::vector<Output> out;
  if (s.outputs.empty()) {
    const auto is_wanted = [](const Item& item) { return !item.hidden && !item.fixed; };
    out.reserve(static_cast<std::size_t>(std::count_if(s.items.begin(), s.items.end(), is_wanted)) + s.measures.size());
    for (const Item& item : s.items) {
      if (is_wanted(item)) out.push_back(of_item(item));
    }
    for (const bool sums : {false, true}) {
      for (const MeasureForms& m : s.measures) {
        if (m.is_sum() == sums) out.push_back(of_measure(m));
      }
    }
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
      if (const Index i = s.find_item(name); i >= 0) {
        out.push_back(of_item(s.items[static_cast<std::size_t>(i)]));
        return true;
      }
      return false;
    };
    if (find(text)) continue;
    const auto refuse = [&] {
      throw Error(Error::Kind::input,
                  {{"/outputs", "'" + text + "' is not a point, vector, scalar, measure or column"}});
    };
    const std::size_t dot = text.rfind('.');
    if (dot == std::string::npos || !find(text.substr(0, dot))) refuse();
    const auto asked = asked_part(std::string_view(text).substr(dot + 1), static_cast<int>(out.back().part_count));
    if (!asked) refuse();
    if (asked->component >= 0) {
      out.back() = column_of(out.back(), static_cast<std::size_t>(asked->component),
                             static_cast<std::size_t>(asked->derivative));
    }
    for (int d = 0; d < 3; ++d) out.back().wanted[d] = out.back().wanted[d] && d == asked->derivative;
  }
  return without_repetition(with_terms(s, std::move(out)));
}

std::vector<Output> limited_outputs(const System& s) {
  std::vector<Output> out;
  for (const Bound& b : s.bounds) out.push_back(of_measure(s.measures[static_cast<std::size_t>(b.measure)]));
  return without_repetition(with_terms(s, std::move(out)));
}

void append_columns(const Output& o, std::vector<std::string>& columns) {
  static constexpr const char* kScalar[3] = {"", ".rate", ".acceleration"};
  static constexpr const char* kVector[3] = {".", ".v", ".a"};
  for (int d = 0; d < 3; ++d) {
    if (!o.wanted[d]) continue;
    if (is_turn(o.all_parts[0].kind)) {  // "B.turn_x" -> "B.wx", "B.alphax"
      const std::string_view body = o.name.substr(0, o.name.rfind('.'));
      columns.push_back(std::string(body) + (d == 1 ? ".w" : ".alpha") + o.name.back());
    } else if (o.component >= 0) {
      columns.push_back(std::string(o.name) + kVector[d] + "xyz"[o.component]);
    } else if (o.part_count == 1) {
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
