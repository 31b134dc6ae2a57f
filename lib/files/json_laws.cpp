#include <algorithm>
#include <cmath>

#include "files/csv.hpp"
#include "files/input_file.hpp"
#include "files/json_reader.hpp"
#include "parallel/free_memory.hpp"
#include "scene/law_sum.hpp"

namespace assur {
namespace {

struct Table {
  std::vector<double> time, value;
};

// Reads rows "t, value". Skips empty lines, lines that begin with '#', and a first line of words. Throws Error
// "FILE:LINE: ..." for an unusable row.
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

// A sum has copies of its tables: a short list may name a large one many times.
void check_tables(std::span<const Law> laws) {
  if (laws.size() < 2) return;
  std::size_t rows = 0;
  for (const Law& law : laws) {
    for (const Law::Part& part : law.parts()) {
      if (const auto* spline = std::get_if<Law::Spline>(&part)) rows += spline->time.size();
    }
  }
  if (rows == 0) return;
  require_memory(2.0 * sizeof(double) * 3 * static_cast<double>(rows),
                 "a sum of laws with tables of " + std::to_string(rows) + " rows in all", "add fewer tables");
}

}  // namespace

// A link inside the folder may lead out of it, so the target of the link decides.
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

void JsonReader::read(Law& out, const vocabulary::About& about, const ValueAt& at) {
  out = law(at, about.means == vocabulary::Means::angle ? angle_unit_ : 1);
}

// Laws of a rotation are named.
void JsonReader::read(std::vector<Law>& out, const vocabulary::About& about, const ValueAt& at) {
  if (about.means != vocabulary::Means::rotation) {
    if (!expect(at, Type::array, "[law, law]")) return;
    for (std::size_t k = 0; k < at.size(); ++k) out.push_back(law(at[k], 1));
    return;
  }
  const std::string_view name = dimension_ == 2 ? "angle" : "euler_zyx";
  Object angles(*this, at, {{name}});
  const JsonNode* node =
      angles.need(name, dimension_ == 2 ? "the law of the angle from +x" : "the laws [psi, theta, phi] of Rz Ry Rx");
  if (node == nullptr) return;
  const ValueAt named{*node, at.where / name};
  if (dimension_ == 2) {
    out.push_back(law(named, angle_unit_));
  } else if (is_list(named, 3, "[psi, theta, phi]")) {
    for (std::size_t k = 0; k < 3; ++k) out.push_back(law(named[k], angle_unit_));
  }
}

Law JsonReader::read_law(std::vector<std::filesystem::path>& files) {
  Law law = this->law({document_.root, Where()}, 1);
  std::erase_if(findings_, [](const Diagnostic& finding) { return finding.what.empty(); });
  if (!findings_.empty()) throw Error(Error::Kind::input, std::move(findings_));
  files.insert(files.end(), files_.begin(), files_.end());
  return law;
}

Law parse_law(std::string_view text, const TableFolders& tables, std::vector<std::filesystem::path>& files) {
  const JsonDocument document = parse_json(text);
  const Parameters none;
  return JsonReader(document, tables, none).read_law(files);
}

Law JsonReader::law(const ValueAt& at, double unit) {
  const auto& [node, where] = at;
  if (node.is(Type::array)) {
    if (at.size() == 0) note(where, "an empty list of laws; write at least one, e.g. [{\"constant\": 0}]");
    std::vector<Law> laws;
    for (std::size_t i = 0; i < at.size(); ++i) laws.push_back(law(at[i], unit));
    check_tables(laws);
    return sum_of(laws);
  }
  if (node.is(Type::number) || node.is(Type::string)) {
    note(where, "a law is wanted here; for a number write {\"constant\": ...}");
    return {};
  }
  static const vocabulary::Keys kKinds{{"constant", "polynomial", "harmonics", "table"}};
  std::vector<std::string_view> told;
  for (const std::string_view kind : kKinds.allowed) {
    if (node.find(kind) != nullptr) told.push_back(kind);
  }
  if (told.size() > 1) {
    note(where, "a law has one kind, not both " + in_quotes(told[0]) + " and " + in_quotes(told[1]) +
                    "; to add laws, write them as a list");
    return {};
  }
  if (told.empty()) {
    Object unknown(*this, at, kKinds);
    if (unknown.is_object() && node.keys().empty()) note(where, "the law is empty; expected " + one_of(kKinds.allowed));
    broken(where);
    return {};
  }
  const std::string_view kind = told[0];
  const ValueAt value{*node.find(kind), where / kind};
  vocabulary::Keys keys{{kind}};
  if (kind == "harmonics") keys.allowed.push_back("offset");
  if (kind == "table") keys.allowed.insert(keys.allowed.end(), {"periodic", "monotone"});
  const Object object(*this, at, keys);
  try {
    if (kind == "constant") return Law::constant(unit * number(value));
    if (kind == "harmonics") return harmonics(value, object, unit);
    if (kind == "table") return table(value, object, unit);
    std::vector<Number> coefficients;
    if (expect(value, Type::array, "[0, 1]")) {
      if (value.size() == 0) note(value.where, "a polynomial needs at least one coefficient");
      for (std::size_t k = 0; k < value.size(); ++k) coefficients.push_back(unit * number(value[k]));
    }
    return Law::polynomial(std::move(coefficients));
  } catch (const Error& error) {
    // Numbers that are not finite were reported at their places.
    if (kind == "table") {
      for (const Diagnostic& finding : error.diagnostics()) note(value.where, finding.what);
    }
    broken(where);
    return {};
  }
}

Law JsonReader::harmonics(const ValueAt& at, const Object& object, double unit) {
  std::vector<Harmonic> terms;
  if (expect(at, Type::array, "[{\"amplitude\": 1, \"frequency\": 2}]")) {
    if (at.size() == 0) {
      note(at.where, "at least one harmonic is wanted; for a number alone write {\"constant\": ...}");
    }
    const vocabulary::Keys keys = vocabulary::keys_of(vocabulary::kHarmonic);
    for (std::size_t i = 0; i < at.size(); ++i) {
      Object item(*this, at[i], keys);
      Harmonic& term = terms.emplace_back();
      fill(term, item, vocabulary::kHarmonic);
      term.amplitude *= unit;
    }
  }
  const JsonNode* offset = object.find("offset");
  const Number middle = offset ? number({*offset, object.where() / "offset"}) : Number(0);
  return Law::harmonics(std::move(terms), unit * middle);
}

// The rows of a table in the scene itself.
Law JsonReader::rows_of_table(const ValueAt& at, const Where& law, bool closes, bool monotone, double unit) {
  Table table;
  const std::size_t before = findings_.size();
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (!is_list(at[i], 2, "[t, value]")) continue;
    table.time.push_back(number(at[i][0]));
    table.value.push_back(unit * number(at[i][1]));
  }
  if (findings_.size() == before) return Law::table(std::move(table.time), std::move(table.value), closes, monotone);
  broken(law);
  return {};
}

Law JsonReader::table(const ValueAt& at, const Object& object, double unit) {
  bool closes = false, monotone = false;
  for (const auto& [key, value] : {std::pair("periodic", &closes), std::pair("monotone", &monotone)}) {
    if (const JsonNode* told = object.find(key)) read(*value, {}, {*told, object.where() / key});
  }
  if (at.node.is(Type::array)) return rows_of_table(at, object.where(), closes, monotone, unit);
  const std::string name = text(at, "drive.csv");
  if (name.empty()) {
    if (at.node.is(Type::string)) note(at.where, "the name of a CSV file is wanted here");
    broken(object.where());
    return {};
  }
  const std::string key =
      name + (closes ? " periodic" : "") + (monotone ? " monotone" : "") + (unit == 1 ? "" : " angle");
  if (const auto found = laws_of_tables_.find(key); found != laws_of_tables_.end()) return found->second;
  if (!tables_.has(name)) {
    throw Error(Error::Kind::input, "the file " + in_quotes(name) +
                                        " is outside the folder of the scene; tables are read only from there, or from "
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
    Law law = Law::table(std::move(rows.time), std::move(rows.value), closes, monotone);
    files_.push_back(tables_.folder / name);
    return laws_of_tables_[key] = std::move(law);
  } catch (const Error& error) {
    throw Error(Error::Kind::input, excerpt(name) + ": " + error.diagnostics().front().what);
  }
}

}  // namespace assur
