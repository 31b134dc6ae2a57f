// Free memory, which is tested before large allocations: Linux promises more memory than there is, and ends the process
// when it writes to it.
#pragma once

#include <filesystem>
#include <string>

namespace assur {

// Bytes that this process may still allocate: the least of the free memory of the machine, the rest of its control
// groups, and the rest of its own limits (RLIMIT_AS, RLIMIT_DATA). HUGE_VAL if all are unknown. root: root of a file
// system with proc and sys; tests provide their own.
[[nodiscard]] double free_memory(const std::filesystem::path& root = "/");

// Bytes of physical memory that this process uses; 0 if unknown.
[[nodiscard]] double taken_memory();

// Throws Error (environment) if fewer bytes are free: "no memory for WHAT (129700 MiB, 22839 free); REMEDY". Small
// requests are not tested.
void require_memory(double bytes, const std::string& what, const std::string& remedy);

}  // namespace assur
