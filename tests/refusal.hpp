// What a call refuses.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "assur/status.hpp"

namespace assur::test {

// The message of the Error (input) that a call throws; "" if it throws none.
template <class Call>
std::string refusal(const Call& call) {
  try {
    call();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), Error::Kind::input);
    return e.what();
  }
  return "";
}

}  // namespace assur::test
