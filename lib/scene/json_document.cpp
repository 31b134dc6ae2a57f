#include "scene/json_document.hpp"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <unordered_map>
#include <unordered_set>

#include "scene/names.hpp"

namespace assur {
namespace {

constexpr std::size_t kDeepest = 32;  // levels; a scene has eight

// Builds the tree from the parser's events.
class Builder : public nlohmann::json_sax<nlohmann::json> {
 public:
  explicit Builder(std::string_view text) : text_(text) {}

  JsonDocument take() { return std::move(document_); }

  bool null() override { return put({}); }
  bool boolean(bool value) override {
    JsonNode node = of(JsonNode::Type::boolean);
    node.boolean = value;
    return put(std::move(node));
  }
  bool number_integer(number_integer_t value) override { return put_number(static_cast<double>(value)); }
  bool number_unsigned(number_unsigned_t value) override { return put_number(static_cast<double>(value)); }
  bool number_float(number_float_t value, const string_t&) override { return put_number(value); }
  bool string(string_t& value) override {
    JsonNode node = of(JsonNode::Type::string);
    node.text = std::move(value);
    return put(std::move(node));
  }
  bool binary(binary_t&) override { return false; }  // text has none
  bool start_object(std::size_t) override { return open(JsonNode::Type::object); }
  bool start_array(std::size_t) override { return open(JsonNode::Type::array); }
  bool key(string_t& name) override {
    open_.back().keys.push_back(std::move(name));
    return true;
  }
  bool end_object() override {
    drop_repeated_keys(open_.back());
    return close();
  }
  bool end_array() override { return close(); }

  bool parse_error(std::size_t position, const std::string&, const nlohmann::json::exception& error) override {
    // "[...] parse error at line 1, column 2: while ... - REASON; last read: '...'; expected ..."
    std::string reason = error.what();
    reason.erase(0, std::min(reason.find("] ") + 2, reason.size()));
    if (const std::size_t colon = reason.find(": ");
        reason.rfind("parse error", 0) == 0 && colon != std::string::npos) {
      reason.erase(0, colon + 2);
    }
    if (const std::size_t dash = reason.find(" - "); dash != std::string::npos) reason.erase(0, dash + 3);
    if (const std::size_t last = reason.find("; last read: "); last != std::string::npos) {
      const std::size_t end = reason.find("; expected ", last);
      reason.erase(last, end == std::string::npos ? std::string::npos : end - last);
    }
    fail(position, reason);
  }

 private:
  static JsonNode of(JsonNode::Type type) {
    JsonNode node;
    node.type = type;
    return node;
  }

  // position: of the character after the one concerned
  [[noreturn]] void fail(std::size_t position, const std::string& reason) const {
    const std::string_view before = text_.substr(0, std::min(position > 0 ? position - 1 : 0, text_.size()));
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    const std::size_t column = before.size() - (before.rfind('\n') + 1) + 1;
    throw Error(Error::Kind::input,
                "line " + std::to_string(line) + ", column " + std::to_string(column) + ": not JSON: " + reason);
  }

  bool put_number(double value) {
    JsonNode node = of(JsonNode::Type::number);
    node.number = value;
    return put(std::move(node));
  }

  bool put(JsonNode node) {
    if (node.order == 0) node.order = count_++;
    if (open_.empty()) {
      document_.root = std::move(node);
    } else {
      open_.back().items.push_back(std::move(node));
    }
    return true;
  }

  bool open(JsonNode::Type type) {
    if (open_.size() == kDeepest) {
      throw Error(Error::Kind::input, "nested more than " + std::to_string(kDeepest) + " levels deep; no scene is");
    }
    open_.push_back(of(type));
    open_.back().order = count_++;
    return true;
  }

  bool close() {
    JsonNode node = std::move(open_.back());
    open_.pop_back();
    return put(std::move(node));
  }

  Where here() const {
    Where where;
    for (std::size_t i = 0; i + 1 < open_.size(); ++i) {
      where = open_[i].is(JsonNode::Type::object) ? where / open_[i].keys.back() : where / open_[i].items.size();
    }
    return where;
  }

  void drop_repeated_keys(JsonNode& object) {
    std::unordered_set<std::string> seen;  // of large objects; small ones are many, and searched
    const auto is_repeated = [&](std::size_t kept, const std::string& key) {
      if (object.keys.size() > 16) return !seen.insert(key).second;
      const auto end = object.keys.begin() + static_cast<std::ptrdiff_t>(kept);
      return std::find(object.keys.begin(), end, key) != end;
    };
    std::size_t kept = 0;
    for (std::size_t i = 0; i < object.keys.size(); ++i) {
      if (is_repeated(kept, object.keys[i])) {
        document_.findings.push_back({(here() / object.keys[i]).text(), "this key appears twice in the same object"});
        continue;
      }
      if (kept != i) {
        object.keys[kept] = std::move(object.keys[i]);
        object.items[kept] = std::move(object.items[i]);
      }
      ++kept;
    }
    object.keys.resize(kept);
    object.items.resize(kept);
  }

  std::string_view text_;
  JsonDocument document_;
  std::vector<JsonNode> open_;
  std::uint32_t count_ = 1;
};

// Finds nodes by pointer; the keys of large objects are indexed once.
class Places {
 public:
  explicit Places(const JsonNode& root) : root_(root) {}

  std::uint32_t order(std::string_view pointer) {
    const JsonNode* node = &root_;
    while (!pointer.empty()) {
      pointer.remove_prefix(1);
      const std::string_view token = pointer.substr(0, pointer.find('/'));
      pointer.remove_prefix(token.size());
      const JsonNode* next = child(*node, token);
      if (next == nullptr) break;
      node = next;
    }
    return node->order;
  }

 private:
  const JsonNode* child(const JsonNode& node, std::string_view token) {
    if (node.is(JsonNode::Type::array)) {
      std::size_t i = node.items.size();
      std::from_chars(token.data(), token.data() + token.size(), i);
      return i < node.items.size() ? &node.items[i] : nullptr;
    }
    auto& index = index_[&node];
    if (index.empty()) {
      for (std::size_t i = 0; i < node.keys.size(); ++i) index.emplace((Where() / node.keys[i]).text(), &node.items[i]);
    }
    const auto found = index.find("/" + std::string(token));
    return found == index.end() ? nullptr : found->second;
  }

  const JsonNode& root_;
  std::unordered_map<const JsonNode*, std::unordered_map<std::string, const JsonNode*>> index_;
};

}  // namespace

const JsonNode* JsonNode::find(std::string_view key) const {
  const auto found = std::find(keys.begin(), keys.end(), key);
  return found == keys.end() ? nullptr : &items[static_cast<std::size_t>(found - keys.begin())];
}

std::string_view with_article(JsonNode::Type type) {
  switch (type) {
    case JsonNode::Type::null:
      return "null";
    case JsonNode::Type::boolean:
      return "true or false";
    case JsonNode::Type::number:
      return "a number";
    case JsonNode::Type::string:
      return "a text";
    case JsonNode::Type::array:
      return "an array";
    case JsonNode::Type::object:
      return "an object";
  }
  return "unknown";
}

JsonDocument parse_json(std::string_view text) {
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) {
    throw Error(Error::Kind::input, "the file is empty; a scene begins with {\"assur\": 1, \"dimension\": 2, ...");
  }
  Builder builder(text);
  nlohmann::json::sax_parse(text.begin(), text.end(), &builder, nlohmann::json::input_format_t::json, true, true);
  return builder.take();
}

void sort_by_place(std::vector<Diagnostic>& findings, const JsonNode& root) {
  Places places(root);
  std::vector<std::pair<std::uint32_t, Diagnostic>> ordered;
  for (Diagnostic& finding : findings) ordered.emplace_back(places.order(finding.where), std::move(finding));
  std::stable_sort(ordered.begin(), ordered.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (std::size_t i = 0; i < findings.size(); ++i) findings[i] = std::move(ordered[i].second);
}

}  // namespace assur
