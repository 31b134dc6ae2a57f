#include "output/replace_file.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include "assur/status.hpp"

namespace assur::output {

void replace_file(const std::filesystem::path& file, std::string_view content) {
  const std::filesystem::path fresh = file.string() + "." + std::to_string(getpid()) + ".new";
  errno = 0;
  std::ofstream out(fresh, std::ios::binary);
  out.write(content.data(), static_cast<std::streamsize>(content.size()));
  out.close();
  std::error_code trouble;
  if (!out) trouble.assign(errno, std::generic_category());
  const bool written = static_cast<bool>(out);
  if (written) std::filesystem::rename(fresh, file, trouble);
  if (written && !trouble) return;
  std::error_code ignored;
  std::filesystem::remove(fresh, ignored);
  throw Error(Error::Kind::environment, "cannot write " + file.string() + ": " + trouble.message());
}

}  // namespace assur::output
