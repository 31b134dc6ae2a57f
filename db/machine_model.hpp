// What the databases say about a machine: the way from files to a PerformanceModel.
#pragma once

#include <span>

#include "assur/performance.hpp"
#include "db/host.hpp"
#include "db/libraries.hpp"
#include "db/places.hpp"

namespace assur::db {

// What machine_model() does, with all that it depends on as arguments. The closest machine that one of the files knows
// decides: this one, else the same processor, else the same microarchitecture. Of equally close ones the samples of the
// earlier files come first: a later one adds what they do not have. Samples of another version of their library are
// left out, and so are damaged ones. Never throws for what is in the files; never writes.
[[nodiscard]] MachineModel read_machine_model(std::span<const DatabaseFile> files, const Host& host,
                                              const LibraryAtHand& library_at_hand);

}  // namespace assur::db
