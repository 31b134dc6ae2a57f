// All names of a scene with their objects.
#pragma once

#include <cstdint>
#include <memory_resource>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "assur/scene.hpp"
#include "scene/names.hpp"

namespace assur {

enum class NameKind : std::uint8_t { point, vector, body, constraint, driver, measure, group };

// "a point", "a vector", ...
[[nodiscard]] std::string_view with_article(NameKind kind);
[[nodiscard]] std::string_view section(NameKind kind);

struct Symbol {
  NameKind kind;
  std::size_t index;       // index in the list of this kind in the scene, or in the body of a member
  std::int64_t body = -1;  // index of a member's body; -1: not a member
  bool fixed = false;      // true if it is known without drivers
  bool broken = false;     // it has an error; later checks skip it
  Triple at{};             // points and vectors: coordinates as written; NaN if a base is broken

  [[nodiscard]] bool is_derived() const { return body >= 0; }
};

// Findings of a reader, by place.
class FindingsByPlace {
 public:
  explicit FindingsByPlace(const std::vector<Diagnostic>& findings);
  void add(const Diagnostic& finding);

  // True if there is a finding at `pointer` or above it.
  [[nodiscard]] bool at_or_above(std::string_view pointer) const;
  // True if there is a finding at `pointer` or below it.
  [[nodiscard]] bool at_or_below(const std::string& pointer) const { return below_.count(pointer) != 0; }
  // True if names may be missing because a section of the scene could not be read.
  [[nodiscard]] bool hides_names() const { return hides_names_; }

 private:
  std::unordered_map<std::string, bool> below_;  // pointers of findings (true) and everything above them (false)
  bool hides_names_ = false;
};

class Symbols {
 public:
  Symbols(const Scene& scene, const FindingsByPlace& known);

  [[nodiscard]] const Symbol* find(std::string_view name) const;
  [[nodiscard]] Symbol* find(std::string_view name);

  // True for names such as "J.axis" that build() gives to parts of joints and bodies.
  [[nodiscard]] bool is_made(std::string_view name) const;

  // Findings about invalid names and names that are used twice.
  [[nodiscard]] const std::vector<Diagnostic>& findings() const { return findings_; }

  // Names of these kinds in the order of the scene, for suggestions.
  [[nodiscard]] std::vector<std::string_view> names(std::initializer_list<NameKind> kinds) const;

 private:
  void enter(std::string_view name, const Where& where, Symbol symbol, const FindingsByPlace& known);

  std::pmr::monotonic_buffer_resource memory_;  // freed as a whole, because millions of small pieces would leave gaps
  std::pmr::unordered_map<std::string_view, Symbol> symbols_{&memory_};
  std::unordered_set<std::string_view> owners_;  // joints and bodies, for names such as "J.axis" that build() gives
  std::vector<std::pair<std::string_view, NameKind>> order_;
  std::vector<Diagnostic> findings_;
};

}  // namespace assur
