// Where the lanes of a pack find a number in a state array.
#pragma once

#include <cstdint>

namespace assur {

// Addresses of one input of a pack in all lanes.
struct InputRow {
  // How the addresses of the lanes follow each other. Two numbers behind the last one of every_second or every_third
  // are read as well.
  enum class Kind : std::uint8_t { same, consecutive, every_second, every_third, scattered };
  std::int32_t address = 0;  // of lane 0
  Kind kind = Kind::scattered;
};

}  // namespace assur
