// Variants of a scene from a CSV: the first line names parameters, each further line is one variant.
#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_set>
#include <utility>

#include "assur/scene.hpp"
#include "files/csv.hpp"
#include "files/input_file.hpp"
#include "parallel/free_memory.hpp"
#include "scene/names.hpp"

namespace assur {
namespace {

constexpr std::size_t kMostVariantFindings = 20;  // more suggest that this is the wrong file
constexpr double kBytesOfParameter = 80;          // of a parameter and its name
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

class VariantReader {
 public:
  explicit VariantReader(std::string source) : source_(std::move(source)) {}

  std::vector<Parameters> read(std::string_view file) {
    while (!is_another_file() && !file.empty()) {
      ++line_;
      std::string_view text = take_line(file);
      if (line_ == 1 && text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
      if (trimmed(text).empty()) {
        if (blank_ == 0) blank_ = line_;
      } else {
        take(text);
      }
    }
    if (findings_.empty()) check_whole();
    if (!findings_.empty()) throw Error(Error::Kind::input, std::move(findings_), source_);
    return std::move(variants_);
  }

 private:
  // Blank lines may end the file. Between rows they are an error, because a value may be missing there.
  void take(std::string_view text) {
    if (blank_ > 0) note(at_line(blank_), "the line is blank; blank lines are allowed only at the end of the file");
    blank_ = 0;
    if (names_.empty()) {
      take_names(text);
    } else {
      take_row(text);
    }
  }

  void take_names(std::string_view text) {
    std::unordered_set<std::string_view> seen;
    for (const std::string_view field : fields_of(text)) {
      if (is_another_file()) return;
      const std::string where = at_line(line_) + ", column " + std::to_string(names_.size() + 1);
      if (field.empty()) {
        note(where, "a name is missing");
      } else if (!is_name(field)) {
        note(where, in_quotes(field) +
                        " is not the name of a parameter; the first line names one for each column, "
                        "separated by commas");
      } else if (!seen.insert(field).second) {
        note(where, in_quotes(field) + " names a column already");
      }
      names_.emplace_back(field);
    }
  }

  void take_row(std::string_view text) {
    const std::vector<std::string_view> fields = fields_of(text);
    if (fields.size() != names_.size()) {
      note(at_line(line_), counted(fields.size(), "value") + ", but " + counted(names_.size(), "column"));
      return;
    }
    Parameters variant;
    for (std::size_t i = 0; i < fields.size() && !is_another_file(); ++i) {
      const double value = parse_number(fields[i]);
      if (std::isnan(value)) {
        note(at_line(line_) + ", column " + std::to_string(i + 1) + " (" + excerpt(names_[i]) + ")",
             fields[i].empty() ? "a number is missing" : in_quotes(fields[i]) + " is not a finite number");
      }
      variant.emplace(names_[i], value);
    }
    variants_.push_back(std::move(variant));
  }

  void check_whole() {
    if (names_.empty()) {
      note("", "the file is empty; its first line names parameters, each further line has their values");
    } else if (variants_.empty()) {
      note("", "the file names " + counted(names_.size(), "parameter") + " but has no line of values");
    }
  }

  [[nodiscard]] bool is_another_file() const { return findings_.size() >= kMostVariantFindings; }
  void note(std::string where, std::string what) { findings_.push_back({std::move(where), std::move(what)}); }

  static std::string at_line(int line) { return "line " + std::to_string(line); }
  static std::string counted(std::size_t count, const std::string& what) {
    return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
  }

  std::string source_;
  int line_ = 0, blank_ = 0;  // the first of the last blank lines; 0: none
  std::vector<std::string> names_;
  std::vector<Parameters> variants_;
  std::vector<Diagnostic> findings_;
};

}  // namespace

std::vector<Parameters> read_variants(const std::filesystem::path& path) {
  const InputFile file = read_input(path, kLargestTable);
  if (!file.why_not.empty()) {
    throw Error(Error::Kind::environment, {{"", "the file of variants cannot be read: " + file.why_not}},
                path.string());
  }
  const auto rows = static_cast<double>(std::count(file.text.begin(), file.text.end(), '\n'));
  const auto commas = static_cast<double>(std::count(file.text.begin(), file.text.end(), ','));
  require_memory(rows * sizeof(Parameters) + (rows + commas) * kBytesOfParameter,
                 "the variants of " + path.string() + ", about " + shortest(rows), "give fewer at a time");
  return VariantReader(path.string()).read(file.text);
}

}  // namespace assur
