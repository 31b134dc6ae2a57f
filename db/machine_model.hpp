// From database files to a PerformanceModel.
#pragma once

#include <span>

#include "assur/performance.hpp"
#include "db/database_files.hpp"
#include "db/host.hpp"
#include "db/libraries.hpp"

namespace assur::db {

// machine_model() with its inputs as arguments. Uses the samples of the most similar machine in the files: this one,
// else the same processor, else the same microarchitecture. If several files know this machine, a later file adds
// samples that the earlier ones do not have. Samples of another version of their library are left out, and
// all of a file whose samples of this machine are damaged. The content of the files causes messages, not exceptions.
// Never writes.
[[nodiscard]] MachineModel read_machine_model(std::span<const DatabaseFile> files, const Host& host,
                                              const LibraryAtHand& library_at_hand);
// The model of another machine, from all samples of the machine whose fingerprint begins like this, of whatever version
// of their libraries. Without samples if no file has this machine.
[[nodiscard]] MachineModel read_model_of(std::span<const DatabaseFile> files, const std::string& fingerprint);

}  // namespace assur::db
