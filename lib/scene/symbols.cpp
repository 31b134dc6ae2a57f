#include "scene/symbols.hpp"

#include <algorithm>

#include "scene/axes.hpp"
#include "scene/scene_source.hpp"

namespace assur {
namespace {

// The pointer of a point, vector, ... that is a list entry or a member of a body.
Where place(NameKind kind, std::string_view name) { return Where("/" + std::string(section(kind))) / name; }

// True if a broken value at `pointer` may hide names.
bool defines_names(std::string_view pointer) {
  static constexpr std::string_view kSections[] = {"",        "/points",      "/vectors", "/bodies",  "/joints",
                                                   "/groups", "/constraints", "/drivers", "/measures"};
  static constexpr std::string_view kBodies = "/bodies/";
  if (pointer.substr(0, kBodies.size()) != kBodies) {
    return std::find(std::begin(kSections), std::end(kSections), pointer) != std::end(kSections);
  }
  const std::string_view body = pointer.substr(kBodies.size());
  const std::string_view part = body.substr(std::min(body.size(), body.find('/')));
  return part.empty() || part == "/points" || part == "/vectors";
}

// True for names such as "J.from" and "J.copy0" that joints and poses add for their own equations: no list shows them.
bool is_hidden(std::string_view name) {
  static constexpr std::string_view kParts[] = {"from", "to", "arm", "zero", "ex", "ey", "ez"};
  static constexpr std::string_view kNumbered[] = {"copy", "across", "meet", "turn_"};
  const std::size_t dot = name.rfind('.');
  if (dot == name.npos) return false;
  const std::string_view part = name.substr(dot + 1);
  return std::find(std::begin(kParts), std::end(kParts), part) != std::end(kParts) ||
         std::any_of(std::begin(kNumbered), std::end(kNumbered), [&](auto stem) { return part.starts_with(stem); });
}

}  // namespace

std::string_view with_article(NameKind kind) {
  static constexpr std::string_view kWords[] = {"a point",  "a vector",  "a body", "a constraint",
                                                "a driver", "a measure", "a group"};
  return kWords[static_cast<std::size_t>(kind)];
}

std::string_view section(NameKind kind) {
  static constexpr std::string_view kSections[] = {"points",  "vectors",  "bodies", "constraints",
                                                   "drivers", "measures", "groups"};
  return kSections[static_cast<std::size_t>(kind)];
}

FindingsByPlace::FindingsByPlace(const std::vector<Diagnostic>& findings) {
  for (const Diagnostic& finding : findings) add(finding);
}

void FindingsByPlace::add(const Diagnostic& finding) {
  const std::string& where = finding.where;
  below_[where] = true;
  hides_names_ = hides_names_ || defines_names(where);
  for (std::size_t end = where.rfind('/'); end != std::string::npos && end > 0; end = where.rfind('/', end - 1)) {
    below_.emplace(where.substr(0, end), false);
  }
  below_.emplace("", false);
}

bool FindingsByPlace::at_or_above(std::string_view pointer) const {
  if (below_.empty()) return false;
  for (std::string above(pointer);;) {
    const auto found = below_.find(above);
    if (found != below_.end() && found->second) return true;
    if (above.empty()) return false;
    above.resize(above.rfind('/'));
  }
}

Symbols::Symbols(const Scene& scene, const FindingsByPlace& known) {
  const auto enter_all = [&](NameKind kind, const auto& items, auto&& fixed, auto&& at) {
    for (std::size_t i = 0; i < items.size(); ++i) {
      enter(items[i].name, place(kind, items[i].name), {kind, i, -1, fixed(items[i]), false, at(items[i])}, known);
    }
  };
  const auto is_fixed = [](const auto& item) { return item.fixed; };
  const auto written = [](const auto& item) { return item.at; };
  const auto never = [](const auto&) { return false; };
  const auto nowhere = [](const auto&) { return Triple{}; };

  for (const Joint& j : scene.joints()) owners_.insert(j.name);
  for (const Body& b : scene.bodies()) {
    const auto is_of_pose = [&](const Member& m) { return m.name == b.name + ".origin" || m.name == b.name + ".ex"; };
    const bool has_pose = std::any_of(b.points.begin(), b.points.end(), is_of_pose) ||
                          std::any_of(b.vectors.begin(), b.vectors.end(), is_of_pose);
    if (!scene.joints().empty() || has_pose) owners_.insert(b.name);
  }
  for (const Body& b : SceneSource::written_bodies(scene)) {
    if (!scene.joints().empty()) owners_.insert(b.name);  // also of bodies that became a part of the ground
  }
  for (const Driver& d : scene.drivers()) {
    if (has_made_axis(d)) owners_.insert(d.name);
  }
  for (const Measure& m : scene.measures()) {
    if (has_made_axis(m)) owners_.insert(m.name);
  }
  symbols_.reserve(2 * (scene.points().size() + scene.vectors().size() + scene.constraints().size()));
  enter_all(NameKind::point, scene.points(), is_fixed, written);
  enter_all(NameKind::vector, scene.vectors(), is_fixed, written);
  enter_all(NameKind::body, scene.bodies(), never, nowhere);
  for (std::size_t b = 0; b < scene.bodies().size(); ++b) {
    const Body& body = scene.bodies()[b];
    const Where where = place(NameKind::body, body.name);
    const auto members = [&](NameKind kind, const std::vector<Member>& list) {
      for (std::size_t i = 0; i < list.size(); ++i) {
        enter(list[i].name, where / section(kind) / list[i].name,
              {kind, i, static_cast<std::int64_t>(b), false, false, {}}, known);
      }
    };
    members(NameKind::point, body.points);
    members(NameKind::vector, body.vectors);
  }
  enter_all(NameKind::constraint, scene.constraints(), never, nowhere);
  enter_all(NameKind::driver, scene.drivers(), never, nowhere);
  enter_all(NameKind::measure, scene.measures(), never, nowhere);
  enter_all(NameKind::group, scene.groups(), never, nowhere);
}

bool Symbols::is_made(std::string_view name) const {
  const std::size_t dot = name.find('.');
  return dot != name.npos && owners_.contains(name.substr(0, dot));
}

void Symbols::enter(std::string_view name, const Where& where, Symbol symbol, const FindingsByPlace& known) {
  symbol.broken = known.at_or_below(where.text()) || known.at_or_above(where.text());
  if (std::string wrong = is_made(name) ? "" : why_no_name(name); !wrong.empty()) {
    symbol.broken = true;
    findings_.push_back({where.text(), std::move(wrong)});
  } else if (name == "ground" && symbol.kind != NameKind::body) {
    findings_.push_back({where.text(), "'ground' is the name of the fixed body; choose another name"});
  }
  const auto [found, is_new] = symbols_.emplace(name, symbol);
  if (is_new) {
    order_.emplace_back(name, symbol.kind);
  } else {
    found->second.broken = true;  // it is unknown which of the two is meant
    findings_.push_back({where.text(), in_quotes(name) + " is " + std::string(with_article(found->second.kind)) +
                                           " already; all kinds share one set of names"});
  }
}

const Symbol* Symbols::find(std::string_view name) const {
  const auto found = symbols_.find(name);
  return found == symbols_.end() ? nullptr : &found->second;
}

Symbol* Symbols::find(std::string_view name) {
  const auto found = symbols_.find(name);
  return found == symbols_.end() ? nullptr : &found->second;
}

std::vector<std::string_view> Symbols::names(std::initializer_list<NameKind> kinds) const {
  std::vector<std::string_view> found;
  for (const auto& [name, kind] : order_) {
    if (std::find(kinds.begin(), kinds.end(), kind) != kinds.end() && !is_hidden(name)) found.push_back(name);
  }
  return found;
}

}  // namespace assur
