// Files that are whole at any time.
#pragma once

#include <filesystem>
#include <string_view>

namespace assur::output {

// Writes another file beside it and gives it the name: a reader finds the old content or the new one. Throws Error
// (environment) if it cannot be written; then the old file stays as it is.
void replace_file(const std::filesystem::path& file, std::string_view content);

}  // namespace assur::output
