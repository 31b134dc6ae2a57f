#include "start/violated.hpp"

#include <algorithm>
#include <string_view>

#include "decimal.hpp"
#include "equations/residual_scale.hpp"
#include "scene/names.hpp"
#include "start/other_postures.hpp"

namespace assur {
namespace {

// "u" for the equation "|u| = 1"; "" for any other equation.
std::string_view vector_of_norm(std::string_view name) {
  constexpr std::string_view kEnd = "| = 1";
  return name.starts_with('|') && name.ends_with(kEnd) ? name.substr(1, name.size() - 1 - kEnd.size())
                                                       : std::string_view();
}

std::string amount_in_words(const System& s, Index equation, const Violation& v) {
  std::vector<Index> mentioned;
  s.mentioned(equation, mentioned);
  const bool of_directions =
      vector_of_norm(s.equation_name(equation)).empty() &&
      std::all_of(mentioned.begin(), mentioned.end(), [&](Index c) { return s.coordinates[idx(c)].dimension == 0; });
  return general(v.by, 3) + (v.is_length ? " m" : of_directions ? " rad" : "");
}

}  // namespace

std::string origin_in_words(const System& s, Index equation) {
  constexpr std::string_view kBody = "body ", kDriver = "driver ";
  const std::string name = s.equation_name(equation);
  if (name.starts_with(kBody)) return "the shape of body " + in_quotes(name.substr(kBody.size()));
  if (name.starts_with(kDriver)) return "driver " + in_quotes(name.substr(kDriver.size()));
  const std::string_view vector = vector_of_norm(name), object = vector.empty() ? std::string_view(name) : vector;
  const std::string_view owner = object.substr(0, object.find('.'));
  const auto has_name = [&](const auto& item) { return item.name == owner; };
  if (owner.size() < object.size() && s.scene != nullptr) {  // made of a joint or body: "C.slide", "rod.meet3"
    if (std::ranges::any_of(s.scene->joints(), has_name)) return "joint " + in_quotes(owner);
    if (std::ranges::any_of(s.scene->bodies(), has_name)) return "the shape of body " + in_quotes(owner);
  }
  return vector.empty() ? in_quotes(name) : "the length of vector " + in_quotes(vector);
}

std::string most_violated(const System& s, std::span<const Index> equations, const std::vector<double>& q) {
  Index worst = equations.front();
  Violation most{};
  const auto relative = [&](const Violation& v) { return v.by / (v.is_length ? s.unit(1) : 1); };
  for (const Index e : equations) {
    const Violation v = violation(s, e, q);
    if (!(relative(v) > relative(most))) continue;  // NaN: a gear whose teeth are far apart has no value
    most = v;
    worst = e;
  }
  const double scale = residual_scale(s, worst, q), phi = std::abs(residual<double>(s, worst, q));
  return origin_in_words(s, worst) + " (relative residual " + general(scale > 0 ? phi / scale : phi, 3) +
         ") is violated most, by " + amount_in_words(s, worst, most);
}

}  // namespace assur
