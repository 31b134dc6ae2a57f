#include "files/json_document.hpp"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <unordered_map>
#include <unordered_set>

#include "parallel/free_memory.hpp"
#include "scene/names.hpp"

namespace assur {
namespace {

constexpr std::size_t kDeepest = 32;              // levels; a scene has nine, plus lists of laws within lists
constexpr std::size_t kMostValues = 100'000'000;  // a million dyads have 17 million
constexpr double kBytesOfValue = 64;              // lower bound while the scene is built; a million dyads take 80

// Number of values of a document: each one begins the text, a nonempty array or a nonempty object, or follows a comma.
std::size_t count_values(std::string_view text) {
  std::size_t values = 1, at = 0;
  char last = ' ';  // the last character that is not a space
  const auto behind = [&](std::string_view end) {
    at = std::min(text.find(end, at + 1), text.size() - 1) + end.size() - 1;
  };
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (c == '/') {
      text.substr(at, 2) == "/*" ? behind("*/") : behind("\n");
      continue;
    }
    if (c == ' ' || c == '\n' || c == '\t' || c == '\r') continue;
    if (c == ',' || c == '[' || c == '{') ++values;
    if ((c == ']' || c == '}') && (last == '[' || last == '{')) --values;
    if (c == '"') {
      while (++at < text.size() && text[at] != '"') at += text[at] == '\\' ? 1 : 0;
    }
    last = c;
  }
  return values;
}

// Checked before memory is taken, because a value of two characters needs many times as much.
void check_size(std::string_view text) {
  const std::size_t values = count_values(text);
  if (values > kMostValues) {
    throw Error(Error::Kind::input,
                "it has " + std::to_string(values) + " values; the limit is " + std::to_string(kMostValues));
  }
  require_memory(static_cast<double>(values) * kBytesOfValue, "the scene of " + std::to_string(values) + " values",
                 "write a smaller scene");
}

// Builds the tree from the parser's events. Items wait until their array or object is closed.
class Builder : public nlohmann::json_sax<nlohmann::json> {
 public:
  explicit Builder(std::string_view text) : text_(text) {
    document_.memory = std::make_unique<std::pmr::monotonic_buffer_resource>();
  }

  JsonDocument take() { return std::move(document_); }

  bool null() override { return put({}); }
  bool boolean(bool value) override { return put(JsonNode(value)); }
  bool number_integer(number_integer_t value) override { return put(JsonNode(static_cast<double>(value))); }
  bool number_unsigned(number_unsigned_t value) override { return put(JsonNode(static_cast<double>(value))); }
  bool number_float(number_float_t value, const string_t&) override { return put(JsonNode(value)); }
  bool string(string_t& value) override { return put(JsonNode(kept(value))); }
  bool binary(binary_t&) override { return false; }  // JSON text has none
  bool start_object(std::size_t) override { return open(JsonNode::Type::object); }
  bool start_array(std::size_t) override { return open(JsonNode::Type::array); }
  bool key(string_t& name) override {
    keys_.push_back(kept(name));
    return true;
  }
  bool end_object() override {
    drop_repeated_keys();
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
  struct Open {
    JsonNode::Type type;
    std::uint32_t order;
    std::size_t items, keys;  // numbers of items and keys before this array or object
  };

  // position: one after the character concerned
  [[noreturn]] void fail(std::size_t position, const std::string& reason) const {
    const std::string_view before = text_.substr(0, std::min(position > 0 ? position - 1 : 0, text_.size()));
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    const std::size_t column = before.size() - (before.rfind('\n') + 1) + 1;
    throw Error(Error::Kind::input,
                "line " + std::to_string(line) + ", column " + std::to_string(column) + ": not JSON: " + reason);
  }

  template <class T>
  T* room_for(std::size_t count, std::size_t more = 0) {
    return static_cast<T*>(document_.memory->allocate(count * sizeof(T) + more, alignof(T)));
  }

  std::string_view kept(const std::string& text) {
    char* const copy = room_for<char>(text.size());
    std::copy(text.begin(), text.end(), copy);
    return {copy, text.size()};
  }

  bool put(JsonNode node) {
    if (node.order() == 0) node.place(count_++);
    (open_.empty() ? document_.root : items_.emplace_back()) = node;
    return true;
  }

  bool open(JsonNode::Type type) {
    if (open_.size() == kDeepest) {
      throw Error(Error::Kind::input,
                  "nested more than " + std::to_string(kDeepest) + " levels deep, which no scene needs");
    }
    open_.push_back({type, count_++, items_.size(), keys_.size()});
    return true;
  }

  bool close() {
    const Open of = open_.back();
    open_.pop_back();
    const std::size_t items = items_.size() - of.items, keys = keys_.size() - of.keys;
    static_assert(sizeof(JsonNode) % alignof(std::string_view) == 0);
    JsonNode* const kept_items = room_for<JsonNode>(items, keys * sizeof(std::string_view));
    std::uninitialized_copy_n(items_.data() + of.items, items, kept_items);
    std::uninitialized_copy_n(keys_.data() + of.keys, keys, reinterpret_cast<std::string_view*>(kept_items + items));
    items_.resize(of.items);
    keys_.resize(of.keys);
    JsonNode node(of.type, kept_items, items);
    node.place(of.order);
    return put(node);
  }

  Where here() const {
    Where where;
    for (std::size_t i = 0; i + 1 < open_.size(); ++i) {
      const Open &outer = open_[i], &inner = open_[i + 1];
      where =
          outer.type == JsonNode::Type::object ? where / keys_[inner.keys - 1] : where / (inner.items - outer.items);
    }
    return where;
  }

  void drop_repeated_keys() {
    const Open& of = open_.back();
    std::unordered_set<std::string_view> seen;  // for large objects; small ones are many, and are searched
    const bool large = keys_.size() - of.keys > 16;
    if (large) seen.reserve(keys_.size() - of.keys);
    std::size_t item = of.items, kept = of.keys;
    const auto is_repeated = [&](std::string_view key) {
      if (large) return !seen.insert(key).second;
      const auto begin = keys_.begin() + static_cast<std::ptrdiff_t>(of.keys);
      const auto end = keys_.begin() + static_cast<std::ptrdiff_t>(kept);
      return std::find(begin, end, key) != end;
    };
    for (std::size_t i = of.keys; i < keys_.size(); ++i) {
      if (is_repeated(keys_[i])) {
        document_.findings.push_back({(here() / keys_[i]).text(), "this key appears twice in the same object"});
        continue;
      }
      items_[item++] = items_[of.items + (i - of.keys)];
      keys_[kept++] = keys_[i];
    }
    items_.resize(item);
    keys_.resize(kept);
  }

  std::string_view text_;
  JsonDocument document_;
  std::vector<Open> open_;
  std::vector<JsonNode> items_;         // items of open arrays and objects, outermost first
  std::vector<std::string_view> keys_;  // their keys
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
    return node->order();
  }

 private:
  const JsonNode* child(const JsonNode& node, std::string_view token) {
    if (node.is(JsonNode::Type::array)) {
      std::size_t i = node.items().size();
      std::from_chars(token.data(), token.data() + token.size(), i);
      return i < node.items().size() ? &node.items()[i] : nullptr;
    }
    auto& index = index_[&node];
    if (index.empty()) {
      for (std::size_t i = 0; i < node.keys().size(); ++i) {
        index.emplace((Where() / node.keys()[i]).text(), &node.items()[i]);
      }
    }
    const auto found = index.find("/" + std::string(token));
    return found == index.end() ? nullptr : found->second;
  }

  const JsonNode& root_;
  std::unordered_map<const JsonNode*, std::unordered_map<std::string, const JsonNode*>> index_;
};

}  // namespace

JsonNode::JsonNode(std::string_view text)
    : type_(Type::string), count_(static_cast<std::uint32_t>(text.size())), characters_(text.data()) {}

JsonNode::JsonNode(Type array_or_object, const JsonNode* items, std::size_t count)
    : type_(array_or_object), count_(static_cast<std::uint32_t>(count)), items_(items) {}

std::string_view JsonNode::text() const {
  return is(Type::string) ? std::string_view(characters_, count_) : std::string_view();
}

std::span<const JsonNode> JsonNode::items() const {
  return is(Type::array) || is(Type::object) ? std::span(items_, count_) : std::span<const JsonNode>();
}

std::span<const std::string_view> JsonNode::keys() const {
  if (!is(Type::object)) return {};
  return {reinterpret_cast<const std::string_view*>(items_ + count_), count_};
}

const JsonNode* JsonNode::find(std::string_view key) const {
  const auto all = keys();
  const auto found = std::find(all.begin(), all.end(), key);
  return found == all.end() ? nullptr : &items()[static_cast<std::size_t>(found - all.begin())];
}

std::string_view with_article(JsonNode::Type type) {
  static constexpr std::string_view kWords[] = {"null", "true or false", "a number", "a text", "an array", "an object"};
  return kWords[static_cast<std::size_t>(type)];
}

JsonDocument parse_json(std::string_view text) {
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) {
    throw Error(Error::Kind::input, "the file is empty; a scene begins with {\"assur\": 1, \"dimension\": 2, ...");
  }
  check_size(text);
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
