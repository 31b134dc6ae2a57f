// Foreign locales, as a program that uses the library may set them.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <clocale>
#include <cstdlib>
#include <filesystem>
#include <locale>
#include <string>

namespace assur::test {

// From construction to destruction, C++ streams write 1234.5 as "1.234,5" or "1,234.5".
class ForeignLocale {
 public:
  explicit ForeignLocale(char point)
      : before_(std::locale::global(std::locale(std::locale::classic(), new Punctuation(point)))) {}
  ~ForeignLocale() { std::locale::global(before_); }
  ForeignLocale(const ForeignLocale&) = delete;
  ForeignLocale& operator=(const ForeignLocale&) = delete;

 private:
  class Punctuation : public std::numpunct<char> {
   public:
    explicit Punctuation(char point) : point_(point) {}

   protected:
    char do_decimal_point() const override { return point_; }
    char do_thousands_sep() const override { return point_ == ',' ? '.' : ','; }
    std::string do_grouping() const override { return "\3"; }

   private:
    char point_;
  };
  std::locale before_;
};

// From construction to destruction, the functions of C (printf, strtod) use a decimal comma. Takes a locale of the
// system, or makes one.
class ForeignLocaleOfC {
 public:
  ForeignLocaleOfC() {
    if (set()) return;
    std::string folder = (std::filesystem::temp_directory_path() / "assur-locale-XXXXXX").string();
    if (mkdtemp(folder.data()) == nullptr) return;
    folder_ = folder;
    const std::string make = "localedef -i de_DE -f UTF-8 '" + folder + "/de_DE.UTF-8' > /dev/null 2>&1";
    if (std::system(make.c_str()) != 0) return;
    setenv("LOCPATH", folder.c_str(), 1);
    set();
    unsetenv("LOCPATH");
  }
  ~ForeignLocaleOfC() {
    std::setlocale(LC_ALL, "C");
    if (!folder_.empty()) std::filesystem::remove_all(folder_);
  }
  ForeignLocaleOfC(const ForeignLocaleOfC&) = delete;
  ForeignLocaleOfC& operator=(const ForeignLocaleOfC&) = delete;

  [[nodiscard]] bool is_set() const { return *std::localeconv()->decimal_point == ','; }

 private:
  bool set() { return std::setlocale(LC_ALL, "de_DE.UTF-8") != nullptr; }

  std::filesystem::path folder_;
};

}  // namespace assur::test
