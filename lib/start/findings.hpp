// What is found out about the equations of a scene while its start posture is assembled.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "assur/structure.hpp"

namespace assur {

struct StartFindings : StructureCounts {
  std::vector<std::string> undetermined;  // names of unknowns that the equations leave free
  std::vector<Redundancy> redundant;      // redundant equations, in the order of `checks`
  std::vector<std::int32_t> checks;       // redundant equations: indices into the equations of the system
  std::vector<Diagnostic> notes;          // e.g. that a group was assembled on another branch
  std::string cannot_assemble;            // Structure::cannot_assemble()
};

}  // namespace assur
