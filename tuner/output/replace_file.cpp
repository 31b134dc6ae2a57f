#include "output/replace_file.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "assur/status.hpp"

namespace assur::output {

namespace fs = std::filesystem;

bool Replacement::Buffer::noted(bool good) {
  if (!good && trouble_ == 0) trouble_ = errno;
  return good;
}

std::filebuf::int_type Replacement::Buffer::overflow(int_type c) {
  errno = 0;
  const int_type result = std::filebuf::overflow(c);
  noted(!traits_type::eq_int_type(result, traits_type::eof()));
  return result;
}

std::streamsize Replacement::Buffer::xsputn(const char* text, std::streamsize size) {
  errno = 0;
  const std::streamsize written = std::filebuf::xsputn(text, size);
  noted(written == size);
  return written;
}

int Replacement::Buffer::sync() {
  errno = 0;
  const int result = std::filebuf::sync();
  noted(result == 0);
  return result;
}

Replacement::Replacement(std::string option, fs::path file)
    : option_(std::move(option)), file_(std::move(file)), out_(&buffer_) {
  if (file_.empty()) return;
  std::error_code none;
  const fs::path target = fs::is_symlink(file_, none) ? fs::weakly_canonical(file_, none) : file_;
  const bool plain = !fs::exists(target, none) || fs::is_regular_file(target, none);
  if (plain) {
    fresh_ = target.string() + "." + std::to_string(getpid()) + ".new";
    if (open(fresh_)) return;
    fresh_.clear();
    if (errno != EACCES || access(target.c_str(), W_OK) != 0) fail(errno);
  }
  if (!open(target)) fail(errno);
}

Replacement::~Replacement() {
  if (fresh_.empty()) return;
  std::error_code ignored;
  fs::remove(fresh_, ignored);
}

bool Replacement::open(const fs::path& name) {
  errno = 0;
  return buffer_.open(name, std::ios::out | std::ios::binary) != nullptr;
}

void Replacement::check() const {
  if (!out_) fail(buffer_.trouble());
}

void Replacement::put() {
  if (file_.empty()) return;
  out_.flush();
  errno = 0;
  const bool closed = buffer_.close_all();
  if (!out_ || !closed) fail(buffer_.trouble());
  if (fresh_.empty()) return;
  std::error_code trouble;
  fs::rename(fresh_, fs::is_symlink(file_, trouble) ? fs::weakly_canonical(file_, trouble) : file_, trouble);
  if (trouble) fail(trouble.value());
  fresh_.clear();
}

void Replacement::fail(int trouble) const {
  const std::string what =
      "cannot write " + file_.string() + ": " + (trouble != 0 ? std::strerror(trouble) : "unknown reason");
  if (option_.empty()) throw Error(Error::Kind::environment, what);
  throw Error(Error::Kind::environment, {{option_, what}});
}

void replace_file(const fs::path& file, std::string_view content) {
  Replacement fresh("", file);
  fresh.stream().write(content.data(), static_cast<std::streamsize>(content.size()));
  fresh.put();
}

}  // namespace assur::output
