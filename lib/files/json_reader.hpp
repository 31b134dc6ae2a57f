// Scene files: from the JSON tree to a SceneBuilder. The reader checks the form of the file, SceneBuilder::build() its
// meaning. After an error the reader notes it and goes on; the item keeps its name, so that references to it cause no
// further errors.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "assur/scene.hpp"
#include "files/expression.hpp"
#include "files/json_document.hpp"
#include "scene/names.hpp"
#include "scene/vocabulary.hpp"

namespace assur {

// Folders in which the tables of a scene may be: its own, and further ones that the caller allows.
struct TableFolders {
  std::filesystem::path folder;  // paths are relative to it
  std::vector<std::filesystem::path> more;

  // True if the path is in or below one of them, after links are followed. The file need not exist.
  [[nodiscard]] bool has(const std::string& name) const;
};

class JsonReader {
 public:
  JsonReader(const JsonDocument& document, TableFolders tables, const Parameters& set);

  // Reads the scene into a builder, with every finding. `name`: used if the scene has none. Throws Error (input) if the
  // document is not a scene at all.
  [[nodiscard]] SceneBuilder read(const std::string& name);
  // Reads a document that is a law. files: receives the paths of its tables. Throws Error (input) with every finding.
  [[nodiscard]] Law read_law(std::vector<std::filesystem::path>& files);

 private:
  using Type = JsonNode::Type;

  // A value of the document with its place.
  struct ValueAt {
    const JsonNode& node;
    Where where;

    ValueAt operator[](std::size_t item) const { return {node.items()[item], where / item}; }
    [[nodiscard]] std::size_t size() const { return node.items().size(); }
  };

  // The keys of an object, allowed and misspelt ones.
  class Object {
   public:
    // Reports unknown keys, and values that are not objects.
    Object(JsonReader& reader, const ValueAt& at, const vocabulary::Keys& keys);
    [[nodiscard]] const JsonNode* find(std::string_view key) const { return node_ ? node_->find(key) : nullptr; }
    // Reports a missing key unless it is misspelt. {} in `what` is replaced by the names of the coordinates.
    [[nodiscard]] const JsonNode* need(std::string_view key, std::string_view what);
    [[nodiscard]] const Where& where() const { return where_; }
    [[nodiscard]] bool is_object() const { return node_ != nullptr; }

   private:
    JsonReader& reader_;
    const JsonNode* node_;
    Where where_;
    std::unordered_set<std::string> misspelt_;
  };

  void note(const Where& where, std::string what);
  void broken(const Where& where) { note(where, ""); }  // the error is reported elsewhere
  [[nodiscard]] bool expect(const ValueAt& at, Type type, std::string_view example);
  // True if objects with this key are refused; reports it.
  bool is_refused(std::string_view key, const vocabulary::Keys& keys, const Where& where);

  // values (json_reader.cpp, laws: json_laws.cpp); after an error NaN, "" and the like. example: as in a file, texts
  // without quotes
  Number number(const ValueAt& at);
  Triple triple(const ValueAt& at);
  std::string text(const ValueAt& at, std::string_view example);
  // True if it is an array of that length; else reports it.
  [[nodiscard]] bool is_list(const ValueAt& at, std::size_t size, std::string_view example);
  void read(Number& out, const vocabulary::About& about, const ValueAt& at);
  void read(std::optional<Number>& out, const vocabulary::About& about, const ValueAt& at);
  void read(bool& out, const vocabulary::About& about, const ValueAt& at);
  void read(Triple& out, const vocabulary::About& about, const ValueAt& at);
  void read(std::string& out, const vocabulary::About& about, const ValueAt& at);
  void read(std::vector<std::string>& out, const vocabulary::About& about, const ValueAt& at);
  void read(Anchor& out, const vocabulary::About& about, const ValueAt& at);
  void read(Direction& out, const vocabulary::About& about, const ValueAt& at);
  void read(std::vector<std::pair<std::string, Number>>& out, const vocabulary::About& about, const ValueAt& at);
  void read(std::vector<Member>& out, const vocabulary::About& about, const ValueAt& at);
  void read(Law& out, const vocabulary::About& about, const ValueAt& at);
  void read(std::vector<Law>& out, const vocabulary::About& about, const ValueAt& at);
  void read(Limit::Reaction& out, const vocabulary::About& about, const ValueAt& at);

  // Reads the members that the row names. False if a required one is missing, which is reported.
  template <class Struct, class Row>
  bool fill(Struct& out, Object& object, const Row& row) {
    bool is_full = true;
    vocabulary::for_each_key(row, [&]<class Content>(const vocabulary::Key<Content>& key) {
      if constexpr (!vocabulary::is_refused<Content>) {
        const JsonNode* node = key.missing.empty() ? object.find(key.name) : object.need(key.name, key.missing);
        if (node != nullptr) put(out, key.content, {*node, object.where() / key.name});
        is_full = is_full && (node != nullptr || key.missing.empty());
      }
    });
    return is_full;
  }
  template <class Struct, class Type>
  void put(Struct& out, const vocabulary::Slot<Struct, Type>& slot, const ValueAt& at) {
    read(out.*slot.member, slot.about, at);
  }
  void put(Combination& out, const vocabulary::Slot<Combination, Number>& constant, const ValueAt& at);
  void put(Limit& out, const vocabulary::Slot<Limit, Number>& bound, const ValueAt& at);
  void put(TimeGrid& out, const vocabulary::Slot<TimeGrid, double>& slot, const ValueAt& at);
  void put(DrivenCoordinate& out, const vocabulary::Slot<DrivenCoordinate, Law>& law, const ValueAt& at);
  template <class Struct, class... Entries>
  void put(Struct& out, const vocabulary::List<Entries...>& list, const ValueAt& at) {
    const bool fits = at.node.is(Type::array) && at.size() == sizeof...(Entries);
    if (!fits) return (void)is_list(at, sizeof...(Entries), example(list));
    std::size_t i = 0;
    std::apply([&](const auto&... entry) { (put(out, entry, at[i++]), ...); }, list.entries);
  }
  template <class Slot>
  static std::string example(const Slot& slot) {
    return "\"" + std::string(slot.about.example) + "\"";
  }
  template <class... Entries>
  static std::string example(const vocabulary::List<Entries...>& list) {
    std::string text;
    std::apply([&](const auto&... entry) { ((text += (text.empty() ? "[" : ", ") + example(entry)), ...); },
               list.entries);
    return text + "]";
  }

  // sections (json_sections.cpp, json_kinds.cpp)
  void check_version() const;
  void read_dimension(Object& scene);
  void read_angles(Object& scene);
  void read_parameters(const JsonNode* section);
  void remember_names(const JsonNode& scene);
  void each(const JsonNode* section, const Where& where,
            const std::function<void(const std::string&, const ValueAt&)>& read);
  template <class Item, class Row>
  void read_items(const JsonNode* section, const Where& where, const Row& row);
  void read_joints(const JsonNode* section);
  void read_constraints(const JsonNode* section);
  void read_drivers(const JsonNode* section);
  void read_measures(const JsonNode* section);
  void read_limits(const JsonNode* section);
  void read_outputs(const JsonNode* section);
  void read_time(const JsonNode* section);

  // constraints, drivers, measures (json_kinds.cpp)
  template <class Item>
  struct Kind;
  template <class Item, class Row, class... Rows>
  void read_kinds(const JsonNode* section, const Where& where, const Row& own, const std::tuple<Rows...>& rows,
                  vocabulary::Keys told);
  template <class Item>
  const Kind<Item>* told_kind(const std::vector<Kind<Item>>& kinds, const vocabulary::Keys& keys, const ValueAt& at);
  [[nodiscard]] bool is_pair_of_points(const JsonNode& node) const;

  // laws (json_laws.cpp); unit: SI value of 1 in the file, angle_unit_ for angles
  Law law(const ValueAt& at, double unit);
  Law harmonics(const ValueAt& at, const Object& object, double unit);
  Law table(const ValueAt& at, const Object& object, double unit);
  Law rows_of_table(const ValueAt& at, const Where& law, bool closes, bool monotone, double unit);

  const JsonDocument& document_;
  TableFolders tables_;
  const Parameters& set_;
  Expressions expressions_;
  std::vector<Diagnostic> findings_;
  int dimension_ = 0;      // 0: not known
  double angle_unit_ = 1;  // rad
  std::unordered_set<std::string_view> point_names_;
  std::unordered_set<std::string_view> angle_names_;  // measures of angles, and sums of them
  std::unordered_set<std::string_view> parameter_names_;
  std::unordered_map<std::string, Law> laws_of_tables_;  // by file: many drivers may share one
  std::vector<std::filesystem::path> files_;             // files of tables
  SceneBuilder builder_{"", 2};
};

// A law of the scene format. files: receives the paths of its tables. Throws Error (input) with every finding.
[[nodiscard]] Law parse_law(std::string_view text, const TableFolders& tables,
                            std::vector<std::filesystem::path>& files);

}  // namespace assur
