#include <filesystem>
#include <system_error>

#include "commands/commands.hpp"

namespace assur::command {
namespace {

// The same file, also where neither is there yet.
bool same_file(const std::string& a, const std::string& b) {
  std::error_code unused;
  if (std::filesystem::equivalent(a, b, unused)) return true;
  return std::filesystem::weakly_canonical(a, unused) == std::filesystem::weakly_canonical(b, unused) && !a.empty();
}

// Devices take any number of outputs.
bool is_file(const std::string& name) {
  std::error_code unused;
  return !name.empty() && name != "-" &&
         (std::filesystem::is_regular_file(name, unused) || !std::filesystem::exists(name, unused));
}

}  // namespace

void refuse_overwriting(const std::vector<std::pair<std::string, std::string>>& outputs,
                        const std::vector<std::string>& inputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const auto& [option, file] = outputs[i];
    if (!is_file(file)) continue;
    for (const std::string& input : inputs) {
      if (is_file(input) && same_file(file, input)) {
        throw Error(Error::Kind::input,
                    {{option, file + " is being read, and would be overwritten; name another file"}});
      }
    }
    for (std::size_t k = 0; k < i; ++k) {
      if (is_file(outputs[k].second) && same_file(file, outputs[k].second)) {
        throw Error(Error::Kind::input, {{option, outputs[k].first + " writes " + file + ", too; name another file"}});
      }
    }
  }
}

}  // namespace assur::command
