#include <filesystem>
#include <system_error>

#include "commands/commands.hpp"
#include "db/database_files.hpp"

namespace assur::command {
namespace {

// True if both names mean the same file, which need not exist.
bool same_file(const std::string& a, const std::string& b) {
  std::error_code unused;
  if (std::filesystem::equivalent(a, b, unused)) return true;
  return std::filesystem::weakly_canonical(a, unused) == std::filesystem::weakly_canonical(b, unused) && !a.empty();
}

// False for devices: they may take several outputs.
bool is_file(const std::string& name) {
  std::error_code unused;
  return !name.empty() && name != "-" &&
         (std::filesystem::is_regular_file(name, unused) || !std::filesystem::exists(name, unused));
}

void refuse_inputs(const std::pair<std::string, std::string>& output, const std::vector<std::string>& inputs) {
  const auto& [option, file] = output;
  if (!is_file(file)) return;
  for (const std::string& input : inputs) {
    if (is_file(input) && same_file(file, input)) {
      refuse(option, file + " is an input and would be overwritten; name another file");
    }
  }
}

}  // namespace

void refuse(const std::string& option, const std::string& what) { throw Error(Error::Kind::input, {{option, what}}); }

void refuse_overwriting(const Common& common, const std::vector<std::pair<std::string, std::string>>& outputs,
                        const std::vector<std::string>& inputs) {
  std::vector<std::string> all = inputs;
  if (common.db.empty()) {
    for (const db::DatabaseFile& database : db::database_files()) all.push_back(database.file.string());
  } else {
    all.push_back(common.db);
  }
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    refuse_inputs(outputs[i], all);
    const auto& [option, file] = outputs[i];
    for (std::size_t k = 0; k < i; ++k) {
      if (is_file(file) && is_file(outputs[k].second) && same_file(file, outputs[k].second)) {
        refuse(option, outputs[k].first + " also writes " + file + "; name another file");
      }
    }
  }
}

void refuse_overwriting(const std::vector<std::pair<std::string, std::string>>& outputs, const Scene& scene) {
  std::vector<std::string> tables;
  for (const std::filesystem::path& table : scene.tables()) tables.push_back(table.string());
  for (const auto& output : outputs) refuse_inputs(output, tables);
}

}  // namespace assur::command
