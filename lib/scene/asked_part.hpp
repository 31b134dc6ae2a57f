// Parts of points, vectors and scalars as outputs: "C.velocity", "C.vx".
#pragma once

#include <optional>
#include <string_view>

namespace assur {

// The part of C that the text after the dot of "C.velocity" or "C.vx" asks for.
struct AskedPart {
  int component = -1;   // -1: all
  int derivative = -1;  // 0, 1, 2; -1: all
};
// Reads such a text. components: of the object, 1 for a scalar. Empty if there is no such part.
[[nodiscard]] std::optional<AskedPart> asked_part(std::string_view part, int components);

}  // namespace assur
