// Every name of a scene and what it stands for.
#pragma once

#include <cstdint>
#include <memory_resource>
#include <string>
#include <string_view>
#include <unordered_map>
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
  std::size_t index;       // in the scene's list of that kind; of a member in its body's list
  std::int64_t body = -1;  // index of a member's body; -1: not a member
  bool fixed = false;      // known without any driver
  bool broken = false;     // something about it was found wrong: it raises no follow-up findings
  Triple at{};             // of points and vectors, as written; NaN where a broken base hides it

  [[nodiscard]] bool is_derived() const { return body >= 0; }
};

// What readers found before, looked up by place.
class Known {
 public:
  explicit Known(const std::vector<Diagnostic>& findings);

  // A finding at `pointer` or above it.
  [[nodiscard]] bool at_or_above(std::string_view pointer) const;
  // A finding at `pointer` or below it.
  [[nodiscard]] bool at_or_below(const std::string& pointer) const { return below_.count(pointer) != 0; }
  // Names may be missing because the part of the scene that defines them could not be read.
  [[nodiscard]] bool hides_names() const { return hides_names_; }

 private:
  std::unordered_map<std::string, bool> below_;  // pointers of findings (true) and everything above them (false)
  bool hides_names_ = false;
};

class Symbols {
 public:
  Symbols(const Scene& scene, const Known& known);

  [[nodiscard]] const Symbol* find(std::string_view name) const;
  [[nodiscard]] Symbol* find(std::string_view name);

  // Bad names and names used twice.
  [[nodiscard]] const std::vector<Diagnostic>& findings() const { return findings_; }

  // Names of these kinds in the order of the scene, for suggestions.
  [[nodiscard]] std::vector<std::string_view> names(std::initializer_list<NameKind> kinds) const;

 private:
  void enter(std::string_view name, const Where& where, Symbol symbol, const Known& known);

  std::pmr::monotonic_buffer_resource memory_;  // given back as a whole: millions of small pieces leave gaps
  std::pmr::unordered_map<std::string_view, Symbol> symbols_{&memory_};
  std::vector<std::pair<std::string_view, NameKind>> order_;
  std::vector<Diagnostic> findings_;
};

}  // namespace assur
