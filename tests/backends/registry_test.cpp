#include <gtest/gtest.h>

#include <set>

#include "assur/backend.hpp"

namespace assur {
namespace {

TEST(Registry, ListsEveryBackendOnceWithAllFunctions) {
  std::set<std::string_view> ids;
  for (const Backend& backend : backends()) {
    EXPECT_TRUE(ids.insert(backend.id).second) << backend.id;
    EXPECT_FALSE(backend.licence.empty());
    const bool present = backend.why_not(Shape{}, ThreadBudget{}).empty();
    EXPECT_EQ(backend.version().empty(), !present) << backend.id;
    EXPECT_EQ(backend.make(ThreadBudget{}, Precision::binary64) != nullptr, present) << backend.id;
  }
  EXPECT_TRUE(ids.contains("eigen"));
  EXPECT_TRUE(ids.contains("klu"));
}

TEST(Registry, CoreBackendsAreRowsOfTheTable) {
  ASSERT_EQ(core_backends().size(), 2u);
  for (const Backend& core : core_backends()) {
    const Backend& row = find_backend(backends(), core.id);
    EXPECT_EQ(row.why_not, core.why_not);
    EXPECT_EQ(row.make, core.make);
    EXPECT_EQ(row.version, core.version);
    EXPECT_EQ(row.licence, core.licence);
    EXPECT_EQ(row.steady, core.steady);
  }
}

TEST(Registry, DenseFactorsHaveALimit) {
  const Backend& eigen = find_backend(backends(), "eigen");
  EXPECT_EQ(eigen.why_not({.n = 16384}, {}), "");
  EXPECT_EQ(eigen.why_not({.n = 16385}, {}), "dense factors of 16385 unknowns are too large; the limit is 16384");
}

std::string refusal(std::span<const Backend> table, std::string_view id) {
  try {
    (void)find_backend(table, id);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::input);
    return error.what();
  }
  return "no error";
}

TEST(Registry, RefusesAnUnknownIdAndListsKnownIds) {
  const Backend table[] = {
      core_backends()[0],
      {.id = "gone",
       .why_not = [](const Shape&, ThreadBudget) { return std::string("install it"); },
       .make = nullptr,
       .version = nullptr,
       .licence = "MIT"},
  };
  EXPECT_EQ(&find_backend(table, "gone"), &table[1]);  // an absent backend is still found
  EXPECT_EQ(refusal(table, "clu"),
            "there is no backend \"clu\"; the backends are eigen, gone (cannot run: install it)");
}

}  // namespace
}  // namespace assur
