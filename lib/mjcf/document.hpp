// MJCF as a tree of elements: files with all that they include, the classes of defaults, and attributes as numbers.
#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace assur::mjcf {

struct Node {
  std::string tag;
  const std::string* file = nullptr;  // as the user named it; belongs to the document
  int line = 0;
  std::vector<std::pair<std::string, std::string>> attributes;
  std::vector<Node> children;

  [[nodiscard]] const std::string* find(std::string_view attribute) const;  // null if there is none
};

// Throws Error (input): "FILE: line 12, <joint> 'hip': what".
[[noreturn]] void refuse(const Node& node, std::string what);

struct Document {
  std::deque<std::string> files;
  Node root;  // <mujoco>; the elements of other files stand where these are included
};

// Reads the file and its included files. Throws Error: environment if the first file cannot be read, input otherwise.
[[nodiscard]] Document read_document(const std::filesystem::path& file);

// Values of attributes for elements that do not have them, by class.
class Defaults {
 public:
  // Adds a top-level <default>.
  void add(const Node& top);
  // The class with this name, which `by` asks for; throws Error if there is none.
  [[nodiscard]] std::size_t find(const std::string& name, const Node& by) const;
  // Null if neither the class nor those around it have the attribute.
  [[nodiscard]] const std::string* find(std::size_t of, std::string_view tag, std::string_view attribute) const;

  static constexpr std::size_t kMain = 0;

 private:
  struct Class {
    std::string name;
    std::size_t parent;
    // By tag and attribute; the last of several elements counts.
    std::map<std::string, std::map<std::string, const std::string*, std::less<>>, std::less<>> own;
  };
  void add(const Node& node, std::size_t of);

  std::vector<Class> classes_ = {{"main", kMain, {}}};
  std::map<std::string, std::size_t> names_ = {{"main", kMain}};
};

// Words between spaces.
[[nodiscard]] std::vector<std::string_view> words_of(std::string_view text);

// The attributes of an element, completed by those of its class. All functions throw Error (input) at wrong values.
class Attributes {
 public:
  // Refuses attributes that are neither in `known` nor in `ignored`.
  Attributes(const Node& node, const Defaults& defaults, std::size_t of);

  [[nodiscard]] const std::string* text(std::string_view name) const;  // null: neither here nor in the class
  [[nodiscard]] bool is_true(std::string_view name, bool otherwise) const;
  [[nodiscard]] double number(std::string_view name, double otherwise) const;
  // At least `least` and at most N numbers; those that are missing are 0. Empty: there is no such attribute.
  template <std::size_t N>
  [[nodiscard]] std::optional<std::array<double, N>> numbers(std::string_view name, std::size_t least = N) const {
    std::array<double, N> values{};
    if (!fill(name, values.data(), least, N)) return std::nullopt;
    return values;
  }
  [[nodiscard]] const Node& node() const { return node_; }
  // Whether the element itself has the attribute.
  [[nodiscard]] bool has_own(std::string_view name) const { return node_.find(name) != nullptr; }

 private:
  bool fill(std::string_view name, double* values, std::size_t least, std::size_t most) const;

  const Node& node_;
  const Defaults& defaults_;
  std::size_t class_;
};

// Numbers of an attribute of the node itself, any count of them.
[[nodiscard]] std::vector<double> numbers_of(const Node& node, std::string_view name, std::string_view text);

// Refuses attributes that the kind of the node does not have. Nodes of kinds that are not read may have any.
void check_attributes(const Node& node);

}  // namespace assur::mjcf
