// Files that are whole at any time.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace assur::output {

// Another file beside `file`, which gets its name once everything is written: a reader finds the old content or the new
// one. What is no plain file, and a file in a folder where none can be made, is written directly. Everything throws
// Error (environment) that says why; then the old file stays as it is.
class Replacement {
 public:
  // option: that the messages name; "" for none. Opened at once: an hour's work is not lost to a misspelt folder.
  Replacement(std::string option, std::filesystem::path file);
  ~Replacement();  // without put() nothing is left
  Replacement(const Replacement&) = delete;
  Replacement& operator=(const Replacement&) = delete;

  [[nodiscard]] std::ostream& stream() { return out_; }
  void check() const;  // throws if something could not be written so far
  void put();

 private:
  // Notes why the system did not take something: the stream itself forgets it.
  class Buffer : public std::filebuf {
   public:
    [[nodiscard]] int trouble() const { return trouble_; }
    bool close_all() { return noted(close() != nullptr); }

   protected:
    int_type overflow(int_type c) override;
    std::streamsize xsputn(const char* text, std::streamsize size) override;
    int sync() override;

   private:
    bool noted(bool good);
    int trouble_ = 0;
  };

  bool open(const std::filesystem::path& name);
  [[noreturn]] void fail(int trouble) const;

  std::string option_;
  std::filesystem::path file_;
  std::filesystem::path fresh_;  // empty: written directly, or given its name
  Buffer buffer_;
  std::ostream out_;
};

void replace_file(const std::filesystem::path& file, std::string_view content);

}  // namespace assur::output
