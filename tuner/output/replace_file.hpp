// Replaces files such that they are complete at any time.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace assur::output {

// Writes to a new file beside `file`, and renames it when everything is written, so that readers find the old content
// or the new one. Other types of files, and files in folders that allow no new file, are written directly. All
// functions throw Error (environment) with the reason; the old file is then unchanged.
class Replacement {
 public:
  // Opens the new file at once, so that a misspelt folder does not cost the work of an hour. option: named in messages;
  // "": none. An empty name of a file is no file: the object is false, and put() does nothing.
  Replacement(std::string option, std::filesystem::path file);
  ~Replacement();  // without put(), removes the new file
  Replacement(const Replacement&) = delete;
  Replacement& operator=(const Replacement&) = delete;

  explicit operator bool() const { return !file_.empty(); }
  [[nodiscard]] std::ostream& stream() { return out_; }
  void check() const;  // throws if something could not be written so far
  void put();

 private:
  // Keeps the error of the system, which a stream does not report.
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
  std::filesystem::path fresh_;  // the new file; empty: written directly, or renamed already
  Buffer buffer_;
  std::ostream out_;
};

void replace_file(const std::filesystem::path& file, std::string_view content);

}  // namespace assur::output
