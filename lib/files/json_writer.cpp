// Scene files: from a scene to JSON text, by the rows of vocabulary.hpp. A value is first written on one line, and
// broken into several ones where it is too long.
#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "assur/scene.hpp"
#include "scene/names.hpp"
#include "scene/vocabulary.hpp"

namespace assur {
namespace {

constexpr std::size_t kWidth = 120;  // columns of a line

// ---- lines

// The entries of an array or object that was written on one line; ", " separates them.
std::vector<std::string_view> entries_of(std::string_view text) {
  std::vector<std::string_view> entries;
  int depth = 0;
  bool is_text = false;
  std::size_t begin = 1;
  for (std::size_t at = 1; at + 1 < text.size(); ++at) {
    const char c = text[at];
    if (is_text) {
      if (c == '\\') ++at;
      is_text = c != '"';
      continue;
    }
    is_text = c == '"';
    if (c == '[' || c == '{') ++depth;
    if (c == ']' || c == '}') --depth;
    if (c != ',' || depth > 0) continue;
    entries.push_back(text.substr(begin, at - begin));
    begin = ++at + 1;
  }
  entries.push_back(text.substr(begin, text.size() - 1 - begin));
  return entries;
}

// Appends a value, which begins in the current line of `out`. indent: that of this line.
void append_laid_out(std::string& out, std::string_view text, std::size_t indent) {
  const std::size_t column = out.size() - (out.rfind('\n') + 1);
  const bool is_object = text.front() == '{', is_array = text.front() == '[';
  if (column + text.size() < kWidth || !(is_object || is_array) || text.size() == 2) {  // a comma may follow
    out += text;
    return;
  }
  const std::size_t inner = indent + 2;
  out += text.front();
  std::size_t used = kWidth;  // columns of the current line
  bool is_first = true;
  for (const std::string_view entry : entries_of(text)) {
    const bool fills = is_array && entry.front() != '{' && used + 1 + entry.size() < kWidth;
    if (!is_first) out += fills ? ", " : ",";
    if (!fills) out.append("\n").append(inner, ' ');
    is_first = false;
    const std::size_t before = out.size();
    if (is_object) {
      const std::size_t value = entry.find("\": ") + 3;  // keys are names
      out += entry.substr(0, value);
      append_laid_out(out, entry.substr(value), inner);
    } else {
      append_laid_out(out, entry, inner);
    }
    const bool is_short = out.find('\n', before) == std::string::npos && entry.front() != '{';
    used = !is_short ? kWidth : fills ? used + 2 + entry.size() : inner + entry.size();
  }
  out.append("\n").append(indent, ' ').append(1, text.back());
}

std::string json_text(std::string_view text) {
  const bool is_plain =
      std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~' && c != '"' && c != '\\'; });
  if (is_plain) return "\"" + std::string(text) + "\"";
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

// JSON reads -0 as an integer, which has no sign.
std::string number(const Number& x) { return x.value() == 0 && std::signbit(x.value()) ? "-0.0" : shortest(x.value()); }

// "[a, b]"; text_of(entry) is the text of an entry
template <class Items, class TextOf>
std::string array_of(const Items& items, const TextOf& text_of) {
  std::string text = "[";
  for (const auto& item : items) (text += text.size() > 1 ? ", " : "") += text_of(item);
  return text + "]";
}

// ---- keys that may be left out

template <class T>
bool is_same(const T& a, const T& b) {
  return a == b;
}
bool is_same(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }
bool is_same(const Number& a, const Number& b) { return is_same(a.value(), b.value()); }
bool is_same(const Triple& a, const Triple& b) {
  return std::equal(a.begin(), a.end(), b.begin(), [](const Number& x, const Number& y) { return is_same(x, y); });
}
bool is_same(const Anchor& a, const Anchor& b) {
  const auto *x = std::get_if<Triple>(&a), *y = std::get_if<Triple>(&b);
  return x != nullptr && y != nullptr ? is_same(*x, *y) : a == b;
}
template <class T>
bool is_same(const std::vector<T>& a, const std::vector<T>& b) {
  return a.empty() && b.empty();
}

// False if reading an object without this key gives the same.
template <class Struct, class Value>
bool is_told(const Struct& item, const vocabulary::Slot<Struct, Value>& slot) {
  static const Struct kNew{};
  return !is_same(item.*slot.member, kNew.*slot.member);
}
template <class Struct, class... Entries>
bool is_told(const Struct&, const vocabulary::List<Entries...>&) {
  return true;
}

// ---- objects

template <class Item>
const std::string& name_of(const Item& item) {
  return item.name;
}
const std::string& name_of(const Limit& limit) { return limit.quantity; }

class JsonWriter {
 public:
  explicit JsonWriter(int dimension) : dimension_(dimension) {}

  // Every item has a name; `fill` appends the keys of an item.
  template <class Items, class Fill>
  void section(std::string_view name, const Items& items, const Fill& fill) {
    if (items.empty()) return;
    std::string text = "{";
    for (const auto& item : items) {
      where_ = Where("/" + std::string(name)) / name_of(item);
      line_ = "{";
      fill(item);
      text.append(text.size() > 1 ? ",\n    " : "\n    ").append(json_text(name_of(item))).append(": ");
      append_laid_out(text, line_ += "}", 4);
    }
    append(name, text + "\n  }");
  }
  template <class Item, class Row>
  void section(std::string_view name, const std::vector<Item>& items, const Row& row) requires requires {
    row.keys;
  }
  {
    section(name, items, [&](const Item& item) { fields(item, row); });
  }
  // For items of several kinds. own: the keys that all kinds have.
  template <class Item, class Row>
  void kinds(std::string_view name, const std::vector<Item>& items, const Row& own) {
    section(name, items, [&](const Item& item) {
      const auto write = [&]<class Kind>(const Kind& kind) { fields(kind, vocabulary::row_of<Kind>()); };
      if constexpr (std::is_same_v<Item, Constraint>) {
        item.visit(write);
      } else {
        std::visit(write, item.kind);
      }
      fields(item, own);
    });
  }
  void value(std::string_view name, std::string_view text) {
    std::string laid_out = "  " + json_text(name) + ": ";
    const std::size_t begin = laid_out.size();
    append_laid_out(laid_out, text, 2);
    append(name, std::string_view(laid_out).substr(begin));
  }
  template <class Struct, class Row>
  std::string object(const Struct& item, const Row& row) {
    std::string outer = std::exchange(line_, "{");
    fields(item, row);
    return std::exchange(line_, std::move(outer)) + "}";
  }
  void note(std::string what) { problems_.push_back({where_.text(), std::move(what)}); }

  std::string take() {
    if (!problems_.empty()) throw Error(Error::Kind::input, std::move(problems_));
    return std::move(text_) + "\n}\n";
  }

 private:
  void append(std::string_view name, std::string_view text) {
    text_.append(text_.empty() ? "{\n  " : ",\n  ").append(json_text(name)).append(": ").append(text);
  }

  void field(std::string_view name, const std::string& text) {
    line_.append(line_.size() > 1 ? ", " : "").append(json_text(name)).append(": ").append(text);
  }

  template <class Struct, class Row>
  void fields(const Struct& item, const Row& row) {
    vocabulary::for_each_key(row, [&]<class Content>(const vocabulary::Key<Content>& key) {
      if constexpr (vocabulary::is_refused<Content>) {
        if (key.name == row.name()) note(std::string(key.content.why));
      } else {
        if (!key.missing.empty() || is_told(item, key.content)) field(key.name, content(item, key.content));
      }
    });
  }

  template <class Struct, class Value>
  std::string content(const Struct& item, const vocabulary::Slot<Struct, Value>& slot) {
    return text(item.*slot.member, slot.about);
  }
  template <class Struct, class... Entries>
  std::string content(const Struct& item, const vocabulary::List<Entries...>& list) {
    std::string all = "[";
    std::apply([&](const auto&... entry) { ((all += (all.size() > 1 ? ", " : "") + content(item, entry)), ...); },
               list.entries);
    return all + "]";
  }

  // ---- values, as JsonReader::read() takes them

  std::string text(double x, const vocabulary::About&) { return number(x); }
  std::string text(const Number& x, const vocabulary::About&) { return number(x); }
  std::string text(const std::optional<Number>& x, const vocabulary::About&) { return number(*x); }
  std::string text(bool x, const vocabulary::About&) { return x ? "true" : "false"; }
  std::string text(const std::string& name, const vocabulary::About&) { return json_text(name); }
  std::string text(const std::vector<std::string>& names, const vocabulary::About&) {
    return array_of(names, json_text);
  }
  std::string text(const Triple& x, const vocabulary::About& about) {
    const auto end = x.begin() + dimension_;
    const bool is_one = std::all_of(x.begin(), end, [&](const Number& other) { return is_same(other, x[0]); });
    if (about.means == vocabulary::Means::each && is_one) return number(x[0]);
    return array_of(std::span(x.begin(), end), number);
  }
  std::string text(const Anchor& anchor, const vocabulary::About& about) {
    return std::visit([&](const auto& own) { return text(own, about); }, anchor);
  }
  std::string text(Limit::Reaction reaction, const vocabulary::About&) {
    return reaction == Limit::Reaction::end ? "\"end\"" : "\"flag\"";
  }
  std::string text(const Direction& d, const vocabulary::About&) {
    return d.is_pair() ? "[" + json_text(d.first) + ", " + json_text(d.second) + "]" : json_text(d.first);
  }
  std::string text(const std::vector<std::pair<std::string, Number>>& terms, const vocabulary::About&) {
    return array_of(terms,
                    [](const auto& term) { return "[" + json_text(term.first) + ", " + number(term.second) + "]"; });
  }
  std::string text(const std::vector<Member>& members, const vocabulary::About& about) {
    std::string all = "{";
    for (const Member& m : members) {
      all.append(all.size() > 1 ? ", " : "").append(json_text(m.name)).append(": ");
      all += m.in_ground ? object(m, vocabulary::kMember) : text(m.local, about);
    }
    return all + "}";
  }
  std::string text(const Law& law, const vocabulary::About&) {
    const auto one = [&](const Law::Part& part) {
      return std::visit([&](const auto& own) { return part_of(own); }, part);
    };
    if (law.parts().empty()) return R"({"constant": 0})";
    return law.parts().size() == 1 ? one(law.parts()[0]) : array_of(law.parts(), one);
  }
  std::string text(const std::vector<Law>& laws, const vocabulary::About& about) {
    const auto one = [&](const Law& law) { return text(law, about); };
    if (about.means != vocabulary::Means::rotation) return array_of(laws, one);
    return dimension_ == 2 ? "{\"angle\": " + one(laws[0]) + "}" : "{\"euler_zyx\": " + array_of(laws, one) + "}";
  }

  std::string part_of(const Law::Polynomial& p) {
    if (p.coefficients.size() > 1) return "{\"polynomial\": " + array_of(p.coefficients, number) + "}";
    return "{\"constant\": " + (p.coefficients.empty() ? "0" : number(p.coefficients[0])) + "}";
  }
  std::string part_of(const Law::Harmonics& h) {
    if (h.terms.empty()) return "{\"constant\": " + number(h.offset) + "}";
    const std::string terms =
        array_of(h.terms, [&](const Harmonic& term) { return object(term, vocabulary::kHarmonic); });
    return "{\"harmonics\": " + terms + (is_same(h.offset, Number(0)) ? "" : ", \"offset\": " + number(h.offset)) + "}";
  }
  std::string part_of(const Law::Spline& s) {
    std::string table = "[";
    for (std::size_t i = 0; i < s.time.size(); ++i) {
      table.append(i > 0 ? ", [" : "[").append(number(s.time[i])).append(", ").append(number(s.value[i])).append("]");
    }
    return "{\"table\": " + table + "]" + (s.periodic ? ", \"periodic\": true" : "") +
           (s.monotone ? ", \"monotone\": true}" : "}");
  }
  std::string part_of(const Law::Function&) {
    note(
        "a law that is a function of the program cannot be written in a file; give a polynomial, harmonics or a table");
    return "";
  }

  int dimension_;
  std::string text_;
  std::string line_;  // text of the current object
  Where where_;       // place of the current item
  std::vector<Diagnostic> problems_;
};

}  // namespace

std::string write_scene(const Scene& scene) {
  const Scene::Parts& parts = scene.written();
  JsonWriter writer(parts.dimension);
  writer.value("assur", "1");
  writer.value("name", json_text(excerpt(parts.name)));
  writer.value("dimension", std::to_string(parts.dimension));
  writer.section("points", parts.points, vocabulary::kPoint);
  writer.section("vectors", parts.vectors, vocabulary::kVector);
  writer.section("bodies", parts.bodies, vocabulary::kBody);
  writer.kinds("joints", parts.joints, vocabulary::kJoint);
  writer.kinds("constraints", parts.constraints, vocabulary::kConstraint);
  writer.kinds("drivers", parts.drivers, vocabulary::kDriver);
  writer.kinds("measures", parts.measures, vocabulary::kMeasure);
  writer.section("limits", parts.limits, vocabulary::kLimit);
  writer.section("groups", parts.groups, vocabulary::kGroup);
  if (!scene.written_outputs_.empty()) writer.value("outputs", array_of(scene.written_outputs_, json_text));
  if (scene.time_.step > 0) writer.value("time", writer.object(scene.time_, vocabulary::kTime));
  return writer.take();
}

void write_scene(const Scene& scene, const std::filesystem::path& file) {
  const std::string text = write_scene(scene);
  errno = 0;
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  if (out) return;
  const std::string reason = errno == 0 ? "" : ": " + std::generic_category().message(errno);
  throw Error(Error::Kind::environment, {{"", "the scene cannot be written" + reason}}, file.string());
}

}  // namespace assur
