// A build without tinyxml2 names the missing package.
#include <gtest/gtest.h>

#include "assur/mjcf.hpp"

namespace assur {
namespace {

TEST(WithoutTinyxml2, ModelsAreRefusedWithTheRemedy) {
  try {
    (void)open_scene("robot.xml");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::environment);
    EXPECT_STREQ(
        error.what(),
        "robot.xml: assur was built without tinyxml2, which reads models of MuJoCo; install the Debian package "
        "libtinyxml2-dev and build assur again");
  }
}

}  // namespace
}  // namespace assur
