// JSON text as a tree that keeps what a careful reader needs: the order of keys, and keys that appear twice.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "assur/status.hpp"

namespace assur {

struct JsonNode {
  enum class Type : std::uint8_t { null, boolean, number, string, array, object };

  Type type = Type::null;
  bool boolean = false;
  std::uint32_t order = 0;  // position among all nodes of the document
  double number = 0;
  std::string text;               // of a string
  std::vector<JsonNode> items;    // of an array or object
  std::vector<std::string> keys;  // of an object, one for each item

  [[nodiscard]] bool is(Type wanted) const { return type == wanted; }
  // Null if there is no such key.
  [[nodiscard]] const JsonNode* find(std::string_view key) const;
};

// "an object", "a number", ...
[[nodiscard]] std::string_view with_article(JsonNode::Type type);

struct JsonDocument {
  JsonNode root;
  std::vector<Diagnostic> findings;  // keys that appear twice; the first one is kept
};

// Comments are allowed. Throws Error (input) with line and column if the text is not JSON.
[[nodiscard]] JsonDocument parse_json(std::string_view text);

// Stable order by the place in the document; what has no place of its own comes where its nearest parent is.
void sort_by_place(std::vector<Diagnostic>& findings, const JsonNode& root);

}  // namespace assur
