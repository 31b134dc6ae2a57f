// JSON text as a tree that keeps the order of keys and reports keys that appear twice.
#pragma once

#include <cstdint>
#include <memory>
#include <memory_resource>
#include <span>
#include <string_view>
#include <vector>

#include "assur/status.hpp"

namespace assur {

// A node. It has 24 bytes, because a scene may have millions; its content belongs to the document.
class JsonNode {
 public:
  enum class Type : std::uint8_t { null, boolean, number, string, array, object };

  JsonNode() = default;
  explicit JsonNode(bool value) : type_(Type::boolean), boolean_(value) {}
  explicit JsonNode(double value) : type_(Type::number), number_(value) {}
  explicit JsonNode(std::string_view text);
  // keys: those of an object, one for each item, stored directly behind the items.
  JsonNode(Type array_or_object, const JsonNode* items, std::size_t count);

  [[nodiscard]] Type type() const { return type_; }
  [[nodiscard]] bool is(Type wanted) const { return type_ == wanted; }
  // False, 0 or empty for nodes of another type.
  [[nodiscard]] bool boolean() const { return boolean_; }
  [[nodiscard]] double number() const { return is(Type::number) ? number_ : 0; }
  [[nodiscard]] std::string_view text() const;
  [[nodiscard]] std::span<const JsonNode> items() const;           // items of an array or object
  [[nodiscard]] std::span<const std::string_view> keys() const;    // keys of an object, one for each item
  [[nodiscard]] const JsonNode* find(std::string_view key) const;  // null if there is no such key
  [[nodiscard]] std::uint32_t order() const { return order_; }     // position among all nodes of the document
  void place(std::uint32_t order) { order_ = order; }

 private:
  Type type_ = Type::null;
  bool boolean_ = false;
  std::uint32_t order_ = 0;
  std::uint32_t count_ = 0;  // number of items or characters
  union {
    double number_ = 0;
    const char* characters_;
    const JsonNode* items_;
  };
};

// "an object", "a number", ...
[[nodiscard]] std::string_view with_article(JsonNode::Type type);

struct JsonDocument {
  std::unique_ptr<std::pmr::monotonic_buffer_resource> memory;  // of the nodes below the root, keys and texts
  JsonNode root;
  std::vector<Diagnostic> findings;  // keys that appear twice; the first one is kept
};

// Comments are allowed. Throws Error (input) with line and column if the text is not JSON, or has more than 100,000,000
// values; (environment) if there is no memory for it.
[[nodiscard]] JsonDocument parse_json(std::string_view text);

// Sorts findings by their place in the document; a place that does not exist counts as its nearest parent. Stable.
void sort_by_place(std::vector<Diagnostic>& findings, const JsonNode& root);

}  // namespace assur
