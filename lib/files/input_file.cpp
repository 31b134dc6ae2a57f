#include "files/input_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "parallel/free_memory.hpp"

namespace assur {
namespace {

constexpr std::uintmax_t kSmall = 16'000'000;  // bytes that every machine has free

std::string reason_of(int error) {
  std::string text = std::generic_category().message(error);
  if (!text.empty() && text.front() >= 'A' && text.front() <= 'Z') text.front() += 'a' - 'A';
  return text;
}

std::string kind_of(mode_t mode) {
  if (S_ISREG(mode)) return "";
  const char* kind = S_ISDIR(mode) ? "folder" : S_ISFIFO(mode) ? "pipe" : S_ISSOCK(mode) ? "socket" : "device";
  return std::string("it is a ") + kind + "; only regular files are read";
}

// Closes the file descriptor that it holds.
struct Descriptor {
  int number = -1;
  explicit Descriptor(int opened) : number(opened) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (number >= 0) ::close(number);
  }
};

// Files of /proc are regular, report no size, and may have no end.
InputFile read_all(int file, std::uintmax_t told, std::uintmax_t most) {
  const InputFile too_large{"", "it is larger than " + std::to_string(most / 1'000'000) + " MB, the limit"};
  if (told > most) return too_large;
  if (told > kSmall && static_cast<double>(told) > free_memory()) {
    return {"", "it is " + std::to_string(told / 1'000'000) + " MB large, more than the free memory"};
  }
  InputFile input;
  std::size_t size = 0;
  for (;;) {
    if (size == input.text.size()) {
      input.text.resize(size == 0 ? static_cast<std::size_t>(std::max<std::uintmax_t>(told + 1, 4096)) : 2 * size);
    }
    const ssize_t more = ::read(file, input.text.data() + size, input.text.size() - size);
    if (more < 0 && errno == EINTR) continue;
    if (more < 0) return {"", reason_of(errno)};
    if (more == 0) break;
    size += static_cast<std::size_t>(more);
    if (size > most) return too_large;
  }
  input.text.resize(size);
  return input;
}

}  // namespace

InputFile read_input(const std::filesystem::path& file, std::uintmax_t most) {
  if (const std::string kind = why_not_regular(file); !kind.empty())
    return {"", kind};  // opening a device may have effects
  const Descriptor opened(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
  struct stat found {};
  if (opened.number < 0 || ::fstat(opened.number, &found) != 0) return {"", reason_of(errno)};
  if (!S_ISREG(found.st_mode)) return {"", kind_of(found.st_mode)};  // it was replaced in the meantime
  return read_all(opened.number, static_cast<std::uintmax_t>(found.st_size), most);
}

std::string why_not_regular(const std::filesystem::path& file) {
  struct stat found {};
  return ::stat(file.c_str(), &found) == 0 ? kind_of(found.st_mode) : "";
}

}  // namespace assur
