#include "builder/validation_vocabulary.hpp"

#include <algorithm>
#include <cmath>

#include "scene/time_grid.hpp"
#include "scene/triple.hpp"

namespace assur {
namespace {

constexpr double kAlong = 1e-6;  // rad; an axis this close to a direction counts as parallel

std::string text(const Direction& d) {
  return d.is_pair() ? "the direction from " + in_quotes(d.first) + " to " + in_quotes(d.second) : in_quotes(d.first);
}

std::size_t rank_of_section(const std::string& pointer) {
  static constexpr std::string_view kOrder[] = {"points",   "vectors", "bodies", "constraints", "drivers",
                                                "measures", "limits",  "groups", "outputs",     "time"};
  const std::string_view section = std::string_view(pointer).substr(0, pointer.find('/', 1));
  const auto found = std::find_if(std::begin(kOrder), std::end(kOrder),
                                  [&](std::string_view name) { return !section.empty() && section.substr(1) == name; });
  return found == std::end(kOrder) ? 0 : static_cast<std::size_t>(found - std::begin(kOrder)) + 1;
}

}  // namespace

std::span<const std::string_view> auxiliaries(const Constraint& constraint) {
  return constraint.visit([]<class Kind>(const Kind&) -> std::span<const std::string_view> {
    const auto& names = vocabulary::row_of<Kind>().unknowns;
    return {names.begin(), std::find(names.begin(), names.end(), "")};
  });
}

bool has_auxiliary(const Constraint& constraint, std::string_view part) {
  const auto names = auxiliaries(constraint);
  return std::find(names.begin(), names.end(), part) != names.end();
}

Validation::Validation(const Scene& scene, const std::vector<Diagnostic>& known)
    : scene_(scene), known_(known), symbols_(scene, known_) {}

std::vector<Diagnostic> Validation::scene() {
  if (dimension() != 2 && dimension() != 3) {  // nothing else can be judged
    report(Where("/dimension"), "the dimension is 2 or 3, not " + std::to_string(dimension()));
    return sorted();
  }
  for (const Diagnostic& finding : symbols_.findings()) report(Where(finding.where), finding.what);
  check_points();
  check_vectors();
  check_bodies();
  check_constraints();
  check_drivers();
  check_measures();
  check_limits();
  check_groups();
  check_outputs();
  check_time();
  return sorted();
}

std::vector<Diagnostic> Validation::outputs() {
  check_outputs();
  return sorted();
}

std::vector<Diagnostic> Validation::time() {
  check_time();
  check_bodies();  // drivers need the places of the bodies
  check_drivers();
  return sorted();
}

void Validation::report(const Where& where, std::string what) {
  if (known_.at_or_above(where.text()) || known_.at_or_below(where.text())) return;
  found_.push_back({where.text(), std::move(what)});
}

std::vector<Diagnostic> Validation::sorted() {
  std::stable_sort(found_.begin(), found_.end(), [](const Diagnostic& a, const Diagnostic& b) {
    return rank_of_section(a.where) < rank_of_section(b.where);
  });
  return std::move(found_);
}

// ---- names

void Validation::unknown_name(const std::string& name, std::initializer_list<NameKind> kinds, const Where& where,
                              bool names_all) {
  if (known_.hides_names()) return;
  std::vector<std::string_view> words;
  for (const NameKind kind : kinds) words.push_back(with_article(kind).substr(2));
  std::string what = "there is no " + one_of(words) + " " + in_quotes(name);
  if (suggestions_left_-- > 0) {
    const auto names = symbols_.names(kinds);
    const std::string near = suggestion(name, names);
    what += near.empty() && names_all ? known_instead(name, names) : near;
  }
  report(where, std::move(what));
}

const Symbol* Validation::want(const std::string& name, NameKind kind, const Where& where) {
  const Symbol* symbol = symbols_.find(name);
  if (symbol == nullptr) {
    unknown_name(name, {kind}, where);
  } else if (symbol->kind != kind && !symbol->broken) {
    report(where, in_quotes(name) + " is " + std::string(with_article(symbol->kind)) + "; " +
                      std::string(with_article(kind)) + " is wanted here");
  }
  return symbol != nullptr && symbol->kind == kind ? symbol : nullptr;
}

Validation::Involved Validation::one(NameKind kind, const std::string& name, const Where& where) {
  const Symbol* symbol = want(name, kind, where);
  if (symbol == nullptr || symbol->broken) return {};
  return {true, symbol->fixed, symbol->at};
}

Validation::Involved Validation::point_or_vector(const std::string& name, const Where& where) {
  const Symbol* symbol = symbols_.find(name);
  if (symbol == nullptr) {
    unknown_name(name, {NameKind::point, NameKind::vector}, where);
    return {};
  }
  if (symbol->broken) return {};
  if (symbol->kind == NameKind::point || symbol->kind == NameKind::vector) return {true, symbol->fixed, symbol->at};
  report(where,
         in_quotes(name) + " is " + std::string(with_article(symbol->kind)) + "; a point or vector is wanted here");
  return {};
}

Validation::Involved Validation::direction(const Direction& direction, const Where& where) {
  if (!direction.is_pair()) {
    const Symbol* symbol = symbols_.find(direction.first);
    if (symbol != nullptr && symbol->kind == NameKind::point && !symbol->broken) {
      report(where,
             in_quotes(direction.first) + " is a point; a direction is a vector or a pair of points [\"A\", \"B\"]");
      return {};
    }
    return vector(direction.first, where);
  }
  const Involved from = point(direction.first, where / std::size_t{0});
  const Involved to = point(direction.second, where / std::size_t{1});
  if (direction.first == direction.second) {
    report(where, filled(vocabulary::kNoDirection, in_quotes(direction.first)));
    return {};
  }
  return pair(from, to, direction, where);
}

Validation::Involved Validation::pair(const Involved& from, const Involved& to, const Direction& names,
                                      const Where& where) {
  const Involved out{from.usable && to.usable, from.fixed && to.fixed, triple::subtract(to.at, from.at)};
  if (!out.usable || !out.fixed || is_made_ || triple::norm(out.at) != 0) return out;
  report(where, "a direction from " + in_quotes(names.first) + " to " + in_quotes(names.second) +
                    ", which are at the same place; points at different places are wanted");
  return {};
}

// An angle about an axis needs directions that are not parallel to the axis.
void Validation::check_axis(const std::string& name, std::initializer_list<std::pair<const Direction&, Involved>> of,
                            const Where& where) {
  const Involved axis = vector(name, where);
  if (!axis.usable) return;
  for (const auto& [direction, involved] : of) {
    const bool itself = !direction.is_pair() && direction.first == name;
    const bool along = axis.fixed && involved.fixed && involved.usable &&
                       !(triple::norm(triple::cross(axis.at, involved.at)) >
                         kAlong * triple::norm(axis.at) * triple::norm(involved.at));
    if (!itself && !along) continue;
    report(where,
           in_quotes(name) + (itself ? " is the axis and a direction" : " is parallel to " + text(direction)) +
               ", so there is no angle about it; choose another axis, e.g. one perpendicular to both directions");
    return;
  }
}

Validation::Involved Validation::scalar(const std::string& text, const Where& where) {
  const std::size_t dot = text.rfind('.');
  const std::string name = text.substr(0, dot);
  const std::string part = dot == std::string::npos ? "" : text.substr(dot + 1);
  const std::string components = dimension() == 2 ? ".x or .y" : ".x, .y or .z";
  const Symbol* symbol = symbols_.find(name);
  if (symbol == nullptr) {
    unknown_name(name, {NameKind::point, NameKind::vector, NameKind::constraint}, where);
    return {};
  }
  if (symbol->broken) return {};
  if (symbol->kind == NameKind::constraint) {
    const Constraint& constraint = scene_.constraints()[symbol->index];
    if (has_auxiliary(constraint, part)) return {true, false};
    std::string has;
    for (const std::string_view one : auxiliaries(constraint)) has += (has.empty() ? "" : " and ") + in_quotes(one);
    report(where, in_quotes(text) + " is not a coordinate; constraint " + in_quotes(name) + " has " +
                      (has.empty() ? "none" : has));
    return {};
  }
  if (symbol->kind != NameKind::point && symbol->kind != NameKind::vector) {
    report(where, in_quotes(name) + " is " + std::string(with_article(symbol->kind)) +
                      "; a coordinate belongs to a point or vector, or is a constraint's lambda or mu");
    return {};
  }
  const bool in_space = part == "z" && dimension() == 3;
  if (part == "x" || part == "y" || in_space) return {true, symbol->fixed};
  report(where, in_quotes(text) + " is not a coordinate; write " + in_quotes(name) + " with " + components);
  return {};
}

bool Validation::finite(const Number& number, const Where& where) {
  if (isfinite(number)) return true;
  report(where, "the value is " + shortest(number.value()) + "; a finite number is wanted");
  return false;
}

// ---- points, vectors, time

void Validation::check_triple(const Triple& at, const Where& where, bool is_direction) {
  bool all_finite = true;
  for (std::size_t k = 0; k < 3; ++k) all_finite = (isfinite(at[k]) || finite(at[k], where / k)) && all_finite;
  if (!all_finite) return;
  if (dimension() == 2 && at[2] != 0) report(where / std::size_t{2}, "a plane scene has no z; write 0 or leave it out");
  if (is_direction && triple::norm(at) == 0) report(where, "a unit vector cannot be made of zeros; give its direction");
}

void Validation::check_points() {
  for (const Point& point : scene_.points()) check_triple(point.at, Where("/points") / point.name / "at", false);
}

void Validation::check_vectors() {
  for (const Vector& vector : scene_.vectors()) check_triple(vector.at, Where("/vectors") / vector.name / "at", true);
}

void Validation::check_time() {
  for (Diagnostic& wrong : wrong_grid(scene_.time())) report(Where(wrong.where), std::move(wrong.what));
}

}  // namespace assur
