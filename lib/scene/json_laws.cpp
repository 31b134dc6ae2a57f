#include <algorithm>
#include <cmath>

#include "scene/csv.hpp"
#include "scene/input_file.hpp"
#include "scene/json_reader.hpp"

namespace assur {
namespace {

struct Table {
  std::vector<double> time, value;
};

// Rows "t, value"; empty lines, lines that begin with '#', and a first line of words are passed over. Throws Error
// "FILE:LINE: ..." at a row that cannot be used.
Table read_table(std::string_view file, const std::string& name) {
  Table table;
  bool may_be_heading = true;
  for (int row = 1; !file.empty(); ++row) {
    const std::string_view text = trimmed(take_line(file));
    if (text.empty() || text.front() == '#') continue;
    const auto at_row = [&](const std::string& what) {
      return Error(Error::Kind::input, name + ":" + std::to_string(row) + ": " + what);
    };
    const std::size_t comma = text.find(',');
    const double time = parse_number(text.substr(0, comma));
    const double value = parse_number(comma == std::string_view::npos ? "" : text.substr(comma + 1));
    const bool heading = may_be_heading && comma != std::string_view::npos && std::isnan(time) && std::isnan(value);
    may_be_heading = false;
    if (heading) continue;
    if (std::isnan(time) || std::isnan(value))
      throw at_row("a row has two numbers \"t, value\", not " + in_quotes(text));
    if (!table.time.empty() && !(time > table.time.back())) {
      throw at_row("the times must ascend, but " + shortest(time) + " s follows " + shortest(table.time.back()) + " s");
    }
    table.time.push_back(time);
    table.value.push_back(value);
  }
  return table;
}

}  // namespace

// A link within the folder may lead out of it: what counts is where the file is.
bool TableFolders::has(const std::string& name) const {
  namespace fs = std::filesystem;
  std::error_code error;
  const auto is_below = [](const fs::path& file, const fs::path& top) {
    return std::mismatch(top.begin(), top.end(), file.begin(), file.end()).first == top.end();
  };
  const auto real = [&error](const fs::path& path) {
    return fs::weakly_canonical(fs::absolute(path.empty() ? fs::path(".") : path, error), error);
  };
  const fs::path file = real(folder / name);
  if (error) return false;
  if (const fs::path own = real(folder); !error && is_below(file, own)) return true;
  return std::any_of(more.begin(), more.end(), [&](const fs::path& one) {
    const fs::path top = real(one);
    return !error && is_below(file, top);
  });
}

Law JsonReader::needed_law(const Object& item, double unit) {
  if (const JsonNode* node = item.find("law")) return law(*node, item.where() / "law", unit);
  note(item.where() / "law", "this is missing: the motion, e.g. {\"polynomial\": [0, 1]}");
  return {};
}

Law JsonReader::law(const JsonNode& node, const Where& where, double unit) {
  if (node.is(Type::array)) {
    Law sum;
    if (node.items().empty()) note(where, "an empty list of laws; write at least one, e.g. [{\"constant\": 0}]");
    for (std::size_t i = 0; i < node.items().size(); ++i)
      sum = i == 0 ? law(node.items()[i], where / i, unit) : sum + law(node.items()[i], where / i, unit);
    return sum;
  }
  if (node.is(Type::number) || node.is(Type::string)) {
    note(where, "a law is wanted here; for a number write {\"constant\": ...}");
    return {};
  }
  static const std::vector<std::string_view> kKinds = {"constant", "polynomial", "harmonics", "table"};
  std::vector<std::string_view> told;
  for (const std::string_view kind : kKinds) {
    if (node.find(kind) != nullptr) told.push_back(kind);
  }
  if (told.size() > 1) {
    note(where, "a law of one kind is wanted, not " + in_quotes(told[0]) + " and " + in_quotes(told[1]) +
                    " together; laws in a list add up");
    return {};
  }
  if (told.empty()) {
    Object unknown(*this, node, where, kKinds);
    if (unknown.is_object() && node.keys().empty()) note(where, "the law is empty; expected " + one_of(kKinds));
    broken(where);
    return {};
  }
  const std::string_view kind = told[0];
  const Where here = where / kind;
  const JsonNode& value = *node.find(kind);
  std::vector<std::string_view> allowed{kind};
  if (kind == "harmonics") allowed.push_back("offset");
  if (kind == "table") allowed.push_back("periodic");
  const Object object(*this, node, where, allowed);
  try {
    if (kind == "constant") return Law::constant(unit * number(value, here));
    if (kind == "polynomial") {
      if (value.is(Type::array) && value.items().empty()) note(here, "a polynomial needs at least one coefficient");
      std::vector<double> coefficients = numbers(value, here);
      for (double& c : coefficients) c *= unit;
      return Law::polynomial(std::move(coefficients));
    }
    if (kind == "harmonics") return harmonics(value, object.find("offset"), where, unit);
    return table(value, object.find("periodic"), where, unit);
  } catch (const Error& error) {
    // Numbers that are not finite were noted where they stand.
    if (kind == "table") {
      for (const Diagnostic& finding : error.diagnostics()) note(here, finding.what);
    }
    broken(where);
    return {};
  }
}

Law JsonReader::harmonics(const JsonNode& node, const JsonNode* offset, const Where& where, double unit) {
  const Where here = where / "harmonics";
  std::vector<Harmonic> terms;
  if (expect(node, Type::array, here, "[{\"amplitude\": 1, \"frequency\": 2}]")) {
    if (node.items().empty())
      note(here, "at least one harmonic is wanted; for a number alone write {\"constant\": ...}");
    for (std::size_t i = 0; i < node.items().size(); ++i) {
      Object item(*this, node.items()[i], here / i, {"amplitude", "frequency", "phase"});
      Harmonic term;
      if (const auto* a = item.need("amplitude", "of the sine"))
        term.amplitude = unit * number(*a, here / i / "amplitude");
      if (const auto* f = item.need("frequency", "in Hz")) term.frequency = number(*f, here / i / "frequency");
      if (const auto* p = item.find("phase")) term.phase = angle_unit_ * number(*p, here / i / "phase");
      terms.push_back(term);
    }
  }
  return Law::harmonics(std::move(terms), offset ? unit * number(*offset, where / "offset") : 0);
}

Law JsonReader::table(const JsonNode& node, const JsonNode* periodic, const Where& where, double unit) {
  const std::string name = text(node, where / "table", "\"drive.csv\"");
  if (name.empty()) {
    if (node.is(Type::string)) note(where / "table", "the name of a CSV file is wanted here");
    broken(where);
    return {};
  }
  const bool closes = periodic != nullptr && boolean(*periodic, where / "periodic");
  const std::string key = name + (closes ? " periodic" : "") + (unit == 1 ? "" : " angle");
  if (const auto found = laws_of_tables_.find(key); found != laws_of_tables_.end()) return found->second;
  if (!tables_.has(name)) {
    throw Error(Error::Kind::input, "the file " + in_quotes(name) +
                                        " is outside the folder of the scene; tables are read from there only, or from "
                                        "folders that you allow (--tables FOLDER)");
  }
  const InputFile file = read_input(tables_.folder / name, kLargestTable);
  if (!file.why_not.empty()) {
    throw Error(Error::Kind::input, "the file " + in_quotes(name) + " cannot be read: " + file.why_not +
                                        "; its path is relative to the scene file");
  }
  Table rows = read_table(file.text, excerpt(name));
  for (double& value : rows.value) value *= unit;
  try {
    Law law = Law::table(std::move(rows.time), std::move(rows.value), closes);
    builder_.table(tables_.folder / name);
    return laws_of_tables_[key] = std::move(law);
  } catch (const Error& error) {
    throw Error(Error::Kind::input, excerpt(name) + ": " + error.diagnostics().front().what);
  }
}

}  // namespace assur
