// Without quad precision, the error of the reference names the missing package.
#include <gtest/gtest.h>

#include <string>

#include "assur/simulator.hpp"

namespace assur {
namespace {

TEST(ForwardError, NamesThePackageThatThisBuildLacks) {
  const Prepared prepared = prepare(sample("four_bar:1"));
  try {
    (void)forward_error(prepared, Simulator(prepared).run());
    FAIL() << "there is no reference in this build";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::environment);
    EXPECT_NE(std::string(error.what()).find("apt install libboost-dev"), std::string::npos) << error.what();
  }
}

TEST(Certificate, NamesThePackageThatThisBuildLacks) {
  try {
    (void)certify(Simulator(prepare(sample("four_bar:1"))));
    FAIL() << "there are no certificates in this build";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::environment);
    EXPECT_NE(std::string(error.what()).find("apt install libboost-dev"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace assur
