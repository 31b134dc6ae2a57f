#include "builder/validation_vocabulary.hpp"

#include <algorithm>

namespace assur {

bool Validation::Involved::is(const Involved& other) const {
  if ((to == nullptr) != (other.to == nullptr)) return false;
  if (to == nullptr) return *name == *other.name;
  return (*name == *other.name && *to == *other.to) || (*name == *other.to && *to == *other.name);
}

std::string Validation::Involved::text() const {
  return to == nullptr ? in_quotes(*name) : "[" + *name + ", " + *to + "]";
}

void Validation::check_value(const std::string& name, const vocabulary::About& about, const Where& where) {
  using vocabulary::Means;
  Involved found;
  switch (about.means) {
    case Means::point:
      found = point(name, where);
      break;
    case Means::vector:
      found = vector(name, where);
      break;
    case Means::point_or_vector:
      found = point_or_vector(name, where);
      break;
    case Means::body:
      found = one(NameKind::body, name, where);
      break;
    case Means::measure:
      found = one(NameKind::measure, name, where);
      break;
    case Means::scalar:
      found = scalar(name, where);
      break;
    default:
      return;
  }
  found.name = &name;
  involved_.push_back(found);
}

void Validation::check_value(const Direction& way, const vocabulary::About&, const Where& where) {
  Involved found = direction(way, where);
  found.name = &way.first;
  if (way.is_pair()) found.to = &way.second;
  involved_.push_back(found);
}

void Validation::check_value(const Number& number, const vocabulary::About&, const Where& where) {
  (void)finite(number, where);
}

void Validation::check_value(const std::optional<Number>& number, const vocabulary::About&, const Where& where) {
  if (number) (void)finite(*number, where);
}

void Validation::check_value(const Triple& numbers, const vocabulary::About&, const Where& where) {
  for (std::size_t k = 0; k < 3; ++k) (void)finite(numbers[k], where / k);
}

void Validation::check_value(const std::vector<std::pair<std::string, Number>>& terms, const vocabulary::About& about,
                             const Where& where) {
  for (std::size_t i = 0; i < terms.size(); ++i) {
    check_value(terms[i].first, about, where / i / std::size_t{0});
    (void)finite(terms[i].second, where / i / std::size_t{1});
  }
}

void Validation::check_value(const Law& law, const vocabulary::About&, const Where& where) { check_law(law, where); }

void Validation::check_value(const std::vector<Law>& laws, const vocabulary::About& about, const Where& where) {
  const bool turns = about.means == vocabulary::Means::rotation;
  for (std::size_t k = 0; k < laws.size(); ++k) {
    check_law(laws[k], !turns ? where / k : dimension() == 3 ? where / "euler_zyx" / k : where / "angle");
  }
}

// Checks that the last two items found differ.
bool Validation::check_differ(const vocabulary::About& about, const Where& where) {
  if (about.same.empty()) return true;
  const Involved &a = involved_.end()[-2], &b = involved_.end()[-1];
  if (!a.usable || !a.is(b)) return true;
  report(where, filled(about.same, a.text(), b.text()));
  return false;
}

bool Validation::all_fixed() const {
  const auto is_fixed = [](const Involved& i) { return i.usable && i.fixed; };
  return !involved_.empty() && std::all_of(involved_.begin(), involved_.end(), is_fixed);
}

}  // namespace assur
