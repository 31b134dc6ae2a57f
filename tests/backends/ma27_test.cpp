// MA27 is loaded at run time. These tests run without HSL, with a substitute of it, and with a library without MA27
// (tests/CMakeLists.txt).
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <iostream>

#include "assur/backend.hpp"
#include "backends/matrices.hpp"

namespace assur::test {
namespace {

void* hsl() {
  void* const first = dlopen("libhsl.so", RTLD_NOW | RTLD_LOCAL);
  return first ? first : dlopen("libcoinhsl.so", RTLD_NOW | RTLD_LOCAL);
}

TEST(Ma27, RunsWithItsLibraryOrExplainsHowToProvideIt) {
  const Backend& ma27 = find_backend(backends(), "ma27");
  const std::string why_not = ma27.why_not({}, {});
  void* const library = hsl();
  if (!library) {
    std::cout << "without HSL\n";
    EXPECT_EQ(why_not.rfind("no libhsl.so or libcoinhsl.so was found: get HSL MA27", 0), 0u) << why_not;
    EXPECT_NE(why_not.find("LD_LIBRARY_PATH"), std::string::npos);
  } else if (!dlsym(library, "ma27ad_")) {
    std::cout << "HSL without MA27\n";
    EXPECT_NE(why_not.find("has no MA27 in double precision"), std::string::npos) << why_not;
  } else {
    std::cout << "with MA27\n";
    EXPECT_EQ(why_not, "");
  }
  EXPECT_EQ(ma27.make({}, Precision::binary64) == nullptr, !why_not.empty());
  EXPECT_EQ(ma27.version().empty(), !why_not.empty());
}

}  // namespace
}  // namespace assur::test
