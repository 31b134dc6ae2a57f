#include "mjcf/document.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "assur/status.hpp"
#include "files/input_file.hpp"
#include "files/json_reader.hpp"
#include "scene/names.hpp"

namespace assur::mjcf {
namespace {

constexpr std::uintmax_t kLargestModel = 16'000'000;  // bytes, all files together
constexpr std::size_t kMostElements = 1'000'000;      // most elements of all files together; each takes about 200 bytes
constexpr double kLargestNumber = 1e100;  // larger numbers are refused, because squares of places must be finite
constexpr int kDeepestInclude = 8;        // files that include each other
constexpr std::size_t kDeepest = 90;      // elements inside each other; tinyxml2 9 allows 98 in one file, 11 allows 498

// The elements that are read, with the attributes that are read and those that are ignored.
struct ReadElement {
  std::string_view tag;
  std::string_view read;
  std::string_view ignored;
};
constexpr ReadElement kKnown[] = {
    {"mujoco", "model", ""},
    {"mujocoinclude", "", ""},
    {"include", "file", ""},
    {"compiler", "angle eulerseq coordinate alignfree autolimits",
     "boundmass boundinertia settotalmass balanceinertia strippath fitaabb fusestatic inertiafromgeom "
     "exactmeshinertia inertiagrouprange saveinertial assetdir meshdir texturedir discardvisual convexhull usethread "
     "conflict"},
    {"default", "class", ""},
    {"body", "name childclass pos quat axisangle xyaxes zaxis euler mocap", "gravcomp user sleep"},
    {"worldbody", "name childclass", ""},
    {"frame", "name childclass pos quat axisangle xyaxes zaxis euler", ""},
    {"joint", "name class type pos axis ref limited range",
     "group springdamper actuatorfrclimited solreflimit solimplimit solreffriction solimpfriction stiffness "
     "actuatorfrcrange actuatorgravcomp margin springref armature damping frictionloss user"},
    {"freejoint", "name", "group align"},
    {"site", "name class pos quat axisangle xyaxes zaxis euler fromto", "type group material size rgba user"},
    {"equality", "class active", "solref solimp"},
    {"connect", "name class active body1 body2 anchor site1 site2", "solref solimp"},
    {"weld", "name class active body1 body2 anchor site1 site2 relpose torquescale", "solref solimp"},
    {"key", "name qpos", "time qvel act ctrl mpos mquat"},
};
// The equality of joints shares its name with joints.
constexpr ReadElement kJointEquality = {"joint", "name class active joint1 joint2 polycoef", "solref solimp"};

const ReadElement* known(const Node& node) {
  if (node.tag == "joint" && (node.find("joint1") != nullptr || node.find("polycoef") != nullptr)) {
    return &kJointEquality;
  }
  const auto found =
      std::find_if(std::begin(kKnown), std::end(kKnown), [&](const ReadElement& k) { return k.tag == node.tag; });
  return found == std::end(kKnown) ? nullptr : found;
}

class Reader {
 public:
  Reader(Document& document, const std::filesystem::path& first)
      : document_(document), first_(first), folder_{first.parent_path(), {}} {}

  void read() {
    const InputFile file = read_input(first_, kLargestModel);
    if (!file.why_not.empty()) {
      throw Error(Error::Kind::environment, {{"", "the model cannot be read: " + file.why_not}}, first_.string());
    }
    document_.files.push_back(first_.string());
    tinyxml2::XMLDocument xml;
    const tinyxml2::XMLElement* root = parse(xml, file.text);
    if (std::string_view(root->Name()) != "mujoco") {
      throw Error(Error::Kind::input,
                  {{"line " + std::to_string(root->GetLineNum()),
                    "a model of MuJoCo begins with <mujoco>, not with <" + excerpt(root->Name()) + ">"}},
                  document_.files.back());
    }
    document_.root = take(*root, 1);
  }

 private:
  const tinyxml2::XMLElement* parse(tinyxml2::XMLDocument& xml, const std::string& text) {
    size_ += text.size();
    const std::string& name = document_.files.back();
    if (size_ > kLargestModel) {
      throw Error(Error::Kind::input, {{"", "the files of the model have more than 16 MB, the limit"}}, name);
    }
    // Elements are counted before the parser takes memory for them.
    for (std::size_t at = text.find('<'); at != text.npos; at = text.find('<', at + 1)) {
      const bool begins_element =
          at + 1 < text.size() && std::string_view("/!?").find(text[at + 1]) == std::string::npos;
      if (begins_element) ++elements_;
    }
    if (elements_ > kMostElements) {
      throw Error(Error::Kind::input, {{"", "the files of the model have more than 1,000,000 elements, the limit"}},
                  name);
    }
    const tinyxml2::XMLError error = xml.Parse(text.data(), text.size());
    if (error == tinyxml2::XML_ELEMENT_DEPTH_EXCEEDED) refuse_depth(xml.ErrorLineNum());
    if (error != tinyxml2::XML_SUCCESS || xml.RootElement() == nullptr) {
      const std::string where = xml.ErrorLineNum() > 0 ? "line " + std::to_string(xml.ErrorLineNum()) : "";
      throw Error(Error::Kind::input, {{where, "the text is not XML: " + std::string(reason(error))}}, name);
    }
    return xml.RootElement();
  }

  // In the same words, whether tinyxml2 or the reader finds it.
  [[noreturn]] void refuse_depth(int line) const {
    throw Error(Error::Kind::input,
                {{"line " + std::to_string(line),
                  "elements are nested more than " + std::to_string(kDeepest) + " levels deep, the limit"}},
                document_.files[file_]);
  }

  static const char* reason(tinyxml2::XMLError error) {
    switch (error) {
      case tinyxml2::XML_SUCCESS:
      case tinyxml2::XML_ERROR_EMPTY_DOCUMENT:
        return "there is no element";
      case tinyxml2::XML_ERROR_MISMATCHED_ELEMENT:
        return "the element that begins here does not end, or another one ends";
      case tinyxml2::XML_ERROR_PARSING_ATTRIBUTE:
        return "an attribute is wrong, or appears twice";
      default:
        return "it cannot be read here";
    }
  }

  Node take(const tinyxml2::XMLElement& element, std::size_t depth) {
    Node node;
    node.tag = element.Name();
    node.file = &document_.files[file_];
    node.line = element.GetLineNum();
    for (const auto* a = element.FirstAttribute(); a != nullptr; a = a->Next()) {
      node.attributes.emplace_back(a->Name(), a->Value());
    }
    if (depth > kDeepest) refuse_depth(node.line);
    check_attributes(node);
    take_children(node, element, depth + 1);
    return node;
  }

  void take_children(Node& into, const tinyxml2::XMLElement& of, std::size_t depth) {
    for (const auto* child = of.FirstChild(); child != nullptr; child = child->NextSibling()) {
      if (const auto* text = child->ToText(); text != nullptr) {
        refuse(into, "there is text in this element: " + in_quotes(text->Value()));
      }
      const auto* element = child->ToElement();
      if (element == nullptr) continue;
      if (std::string_view(element->Name()) == "include") {
        include(into, *element, depth);
      } else {
        into.children.push_back(take(*element, depth));
      }
    }
  }

  // The children of the root of another file take the place of the element.
  void include(Node& into, const tinyxml2::XMLElement& element, std::size_t depth) {
    Node self;
    self.tag = "include";
    self.file = &document_.files[file_];
    self.line = element.GetLineNum();
    check_attributes(self);
    const char* name = element.Attribute("file");
    if (name == nullptr || *name == '\0') refuse(self, "the attribute 'file' is missing");
    if (!folder_.has(name)) {
      refuse(self,
             "the file " + in_quotes(name) + " is outside the folder of the model; files are included only from there");
    }
    const std::filesystem::path path = folder_.folder / name;
    if (!included_.insert(path.lexically_normal().string()).second ||
        path.lexically_normal() == first_.lexically_normal()) {
      refuse(self, "the file " + in_quotes(name) + " is included a second time");
    }
    if (++includes_ > kDeepestInclude) refuse(self, "files include each other more than 8 times, the limit");
    const InputFile file = read_input(path, kLargestModel);
    if (!file.why_not.empty()) {
      refuse(self, "the file " + in_quotes(name) + " cannot be read: " + file.why_not +
                       "; its path is relative to the first file of the model");
    }
    document_.files.push_back(path.string());
    const std::size_t outer = std::exchange(file_, document_.files.size() - 1);
    tinyxml2::XMLDocument xml;
    const tinyxml2::XMLElement* root = parse(xml, file.text);
    const std::string_view tag = root->Name();
    if (tag != "mujoco" && tag != "mujocoinclude") {
      refuse(self, "the file " + in_quotes(name) + " begins with <" + excerpt(tag) + ">; <mujocoinclude> is wanted");
    }
    take_children(into, *root, depth);
    file_ = outer;
    --includes_;
  }

  Document& document_;
  std::filesystem::path first_;
  TableFolders folder_;
  std::size_t file_ = 0;
  std::uintmax_t size_ = 0;
  std::size_t elements_ = 0;
  int includes_ = 0;
  std::set<std::string> included_;
};

std::string place_of(const Node& node) {
  std::string place = "line " + std::to_string(node.line) + ", <" + excerpt(node.tag) + ">";
  const std::string* name = node.find("name");
  return name == nullptr ? place : place + " " + in_quotes(*name);
}

}  // namespace

const std::string* Node::find(std::string_view attribute) const {
  for (const auto& [name, value] : attributes) {
    if (name == attribute) return &value;
  }
  return nullptr;
}

void refuse(const Node& node, std::string what) {
  throw Error(Error::Kind::input, {{place_of(node), std::move(what)}}, *node.file);
}

Document read_document(const std::filesystem::path& file) {
  Document document;
  Reader(document, file).read();
  return document;
}

void check_attributes(const Node& node) {
  const ReadElement* kind = known(node);
  if (kind == nullptr) return;
  std::vector<std::string_view> all = words_of(kind->read);
  const std::vector<std::string_view> read = all, ignored = words_of(kind->ignored);
  all.insert(all.end(), ignored.begin(), ignored.end());
  for (const auto& [name, value] : node.attributes) {
    if (std::find(all.begin(), all.end(), name) == all.end()) {
      refuse(node, "there is no attribute " + in_quotes(name) + suggestion(name, all));
    }
  }
}

std::vector<std::string_view> words_of(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  std::vector<std::string_view> words;
  for (std::size_t at = text.find_first_not_of(kSpace); at != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(kSpace, at), text.size());
    words.push_back(text.substr(at, end - at));
    at = text.find_first_not_of(kSpace, end);
  }
  return words;
}

// ---- defaults

void Defaults::add(const Node& top) {
  if (const std::string* name = top.find("class"); name != nullptr) {
    if (*name != classes_[kMain].name && classes_.size() + classes_[kMain].own.size() > 1) {
      refuse(top, "the class of the outermost <default> is " + in_quotes(classes_[kMain].name) + " already");
    }
    names_.erase(classes_[kMain].name);
    names_.emplace(*name, kMain);
    classes_[kMain].name = *name;
  }
  add(top, kMain);
}

void Defaults::add(const Node& node, std::size_t of) {
  for (const Node& child : node.children) {
    if (child.tag != "default") {
      auto& own = classes_[of].own[child.tag];
      for (const auto& [name, value] : child.attributes) own[name] = &value;
      continue;
    }
    const std::string* name = child.find("class");
    if (name == nullptr) refuse(child, "the attribute 'class' is missing");
    if (!names_.emplace(*name, classes_.size()).second) {
      refuse(child, "the class " + in_quotes(*name) + " appears twice");
    }
    classes_.push_back({*name, of, {}});
    add(child, classes_.size() - 1);
  }
}

std::size_t Defaults::find(const std::string& name, const Node& by) const {
  if (const auto found = names_.find(name); found != names_.end()) return found->second;
  std::vector<std::string_view> names;
  for (const Class& c : classes_) names.push_back(c.name);
  refuse(by, "there is no class " + in_quotes(name) + known_instead(name, names));
}

const std::string* Defaults::find(std::size_t of, std::string_view tag, std::string_view attribute) const {
  for (;; of = classes_[of].parent) {
    if (const auto own = classes_[of].own.find(tag); own != classes_[of].own.end()) {
      if (const auto value = own->second.find(attribute); value != own->second.end()) return value->second;
    }
    if (of == kMain) return nullptr;
  }
}

// ---- attributes

Attributes::Attributes(const Node& node, const Defaults& defaults, std::size_t of)
    : node_(node), defaults_(defaults), class_(of) {}

const std::string* Attributes::text(std::string_view name) const {
  if (const std::string* own = node_.find(name); own != nullptr) return own;
  const bool is_equality = known(node_) == &kJointEquality || node_.tag == "connect" || node_.tag == "weld";
  return defaults_.find(class_, is_equality ? "equality" : std::string_view(node_.tag), name);
}

bool Attributes::is_true(std::string_view name, bool otherwise) const {
  const std::string* value = text(name);
  if (value == nullptr) return otherwise;
  if (*value != "true" && *value != "false") {
    refuse(node_, "the attribute " + in_quotes(name) + " is true or false, not " + in_quotes(*value));
  }
  return *value == "true";
}

double Attributes::number(std::string_view name, double otherwise) const {
  const auto value = numbers<1>(name);
  return value ? (*value)[0] : otherwise;
}

bool Attributes::fill(std::string_view name, double* values, std::size_t least, std::size_t most) const {
  const std::string* value = text(name);
  if (value == nullptr) return false;
  const std::vector<double> numbers = numbers_of(node_, name, *value);
  if (numbers.size() < least || numbers.size() > most) {
    const std::string count =
        least == most ? std::to_string(most) : std::to_string(least) + " to " + std::to_string(most);
    refuse(node_, "the attribute " + in_quotes(name) + " has " + std::to_string(numbers.size()) + " numbers; " + count +
                      (most == 1 ? " is wanted" : " are wanted"));
  }
  std::copy(numbers.begin(), numbers.end(), values);
  return true;
}

std::vector<double> numbers_of(const Node& node, std::string_view name, std::string_view text) {
  std::vector<double> numbers;
  for (const std::string_view word : words_of(text)) {
    const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
    double number = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (error != std::errc() || end != digits.data() + digits.size() || !std::isfinite(number)) {
      refuse(node, "the attribute " + in_quotes(name) + " has " + in_quotes(word) + ", which is not a finite number");
    }
    if (std::abs(number) > kLargestNumber) {
      refuse(node, "the attribute " + in_quotes(name) + " has " + in_quotes(word) + "; the limit is 1e100");
    }
    numbers.push_back(number);
  }
  return numbers;
}

}  // namespace assur::mjcf
