// Scene files: from the JSON tree to a SceneBuilder. The reader judges the shape of the file; what the scene means is
// judged by SceneBuilder::build(). Whatever is wrong is noted and read on: the item keeps its name, so that nothing
// that refers to it is found wrong as well.
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
#include "scene/expression.hpp"
#include "scene/json_document.hpp"
#include "scene/names.hpp"

namespace assur {

// Where the tables of a scene may be: in its folder, and in those that the caller allows.
struct TableFolders {
  std::filesystem::path folder;  // paths are relative to it
  std::vector<std::filesystem::path> more;

  // True if the file is in one of them, whether it is there or not; links are followed.
  [[nodiscard]] bool has(const std::string& name) const;
};

class JsonReader {
 public:
  JsonReader(const JsonDocument& document, TableFolders tables, const Parameters& set);

  // The scene, not yet built, with every finding. `name`: of a scene that has none. Throws Error (input) for what is no
  // scene at all.
  [[nodiscard]] SceneBuilder read(const std::string& name);

 private:
  using Type = JsonNode::Type;

  // An object's keys: the allowed ones, the misspelt ones.
  class Object {
   public:
    // Reports keys that are not among `allowed`, and a node that is no object.
    Object(JsonReader& reader, const JsonNode& node, Where where, std::vector<std::string_view> allowed);
    [[nodiscard]] const JsonNode* find(std::string_view key) const { return node_ ? node_->find(key) : nullptr; }
    // Reports a missing key, unless it is there but misspelt.
    [[nodiscard]] const JsonNode* need(std::string_view key, std::string_view what);
    [[nodiscard]] const Where& where() const { return where_; }
    [[nodiscard]] bool is_object() const { return node_ != nullptr; }

   private:
    JsonReader& reader_;
    const JsonNode* node_;
    Where where_;
    std::unordered_set<std::string> misspelt_;
  };

  // A kind of constraint, driver or measure: the key that tells it, the keys that go with it, and its reader.
  template <class Item>
  struct Kind {
    std::string_view key;
    std::vector<std::string_view> more;
    decltype(Item::kind) (JsonReader::*read)(const Object&, const JsonNode&);
  };

  void note(const Where& where, std::string what);
  void broken(const Where& where) { note(where, ""); }  // wrong for a reason noted elsewhere
  [[nodiscard]] bool expect(const JsonNode& node, Type type, const Where& where, std::string_view example);

  // values (json_reader.cpp); NaN, "" and the like after a finding
  double number(const JsonNode& node, const Where& where);
  std::vector<double> numbers(const JsonNode& node, const Where& where);
  Triple triple(const JsonNode& node, const Where& where);
  bool boolean(const JsonNode& node, const Where& where);
  std::string text(const JsonNode& node, const Where& where, std::string_view example);
  std::vector<std::string> texts(const JsonNode& node, const Where& where, std::string_view example);
  Direction direction(const JsonNode& node, const Where& where);
  // The items of an array of that length, at least 1; else a finding, and none.
  std::span<const JsonNode> list(const JsonNode& node, std::size_t size, const Where& where, std::string_view example);
  // Two point names.
  std::array<std::string, 2> pair(const JsonNode& node, const Where& where);
  void each(const JsonNode* section, const Where& where,
            const std::function<void(const std::string&, const JsonNode&, const Where&)>& read);

  // sections (json_reader.cpp, json_sections.cpp)
  void check_version() const;
  void read_dimension(Object& scene);
  void read_angles(Object& scene);
  void read_parameters(const JsonNode* section);
  void remember_names(const JsonNode& scene);
  void read_points(const JsonNode* section);
  void read_vectors(const JsonNode* section);
  void read_bodies(const JsonNode* section);
  void read_groups(const JsonNode* section);
  void read_outputs(const JsonNode* section);
  void read_time(const JsonNode* section);
  void read_members(const JsonNode* section, const Where& where, std::vector<Member>& members);

  // constraints, drivers, measures (json_kinds.cpp)
  void read_constraints(const JsonNode* section);
  void read_drivers(const JsonNode* section);
  void read_measures(const JsonNode* section);
  template <class Item>
  void read_kinds(const JsonNode* section, const Where& where, const std::vector<Kind<Item>>& kinds,
                  const std::vector<std::pair<std::string_view, std::string_view>>& later);
  bool is_point(const std::string& name) const { return point_names_.count(name) != 0; }

  decltype(Constraint::kind) distance(const Object& item, const JsonNode& node);
  decltype(Constraint::kind) equal_distance(const Object& item, const JsonNode& node);
  decltype(Constraint::kind) dot(const Object& item, const JsonNode& node);
  decltype(Constraint::kind) parallel(const Object& item, const JsonNode& node);
  decltype(Constraint::kind) linear(const Object& item, const JsonNode& node);
  decltype(Constraint::kind) fixed_coordinate(const Object& item, const JsonNode& node);
  decltype(Constraint::kind) on_line(const Object& item, const JsonNode& node);
  decltype(Constraint::kind) on_plane(const Object& item, const JsonNode& node);
  decltype(Driver::kind) driven_angle(const Object& item, const JsonNode& node);
  decltype(Driver::kind) driven_distance(const Object& item, const JsonNode& node);
  decltype(Driver::kind) driven_coordinate(const Object& item, const JsonNode& node);
  decltype(Driver::kind) pose(const Object& item, const JsonNode& node);
  decltype(Measure::kind) measured_angle(const Object& item, const JsonNode& node);
  decltype(Measure::kind) measured_distance(const Object& item, const JsonNode& node);
  decltype(Measure::kind) measured_coordinate(const Object& item, const JsonNode& node);
  decltype(Measure::kind) sum(const Object& item, const JsonNode& node);
  bool is_angle(const std::string& measure) const { return angle_names_.count(measure) != 0; }

  // laws (json_laws.cpp); unit: SI value of 1 in the file, angle_unit_ for angles
  Law law(const JsonNode& node, const Where& where, double unit);
  Law needed_law(const Object& item, double unit);
  Law harmonics(const JsonNode& node, const JsonNode* offset, const Where& where, double unit);
  Law table(const JsonNode& node, const JsonNode* periodic, const Where& where, double unit);

  const JsonDocument& document_;
  TableFolders tables_;
  const Parameters& set_;
  Expressions expressions_;
  std::vector<Diagnostic> findings_;
  int dimension_ = 0;      // 0: not known
  double angle_unit_ = 1;  // rad
  std::unordered_set<std::string_view> point_names_;
  std::unordered_set<std::string_view> angle_names_;  // measures of angles
  std::unordered_set<std::string_view> parameter_names_;
  std::unordered_map<std::string, Law> laws_of_tables_;  // by file: many drivers may share one
  SceneBuilder builder_{"", 2};
};

}  // namespace assur
