// Memory that is promised but not there ends the process when it is written, so it is asked for first.
#pragma once

#include <filesystem>
#include <string>

namespace assur {

// Bytes that this process may still take: the least of what the machine has, its control groups, and its own limits
// (RLIMIT_AS, RLIMIT_DATA) leave. HUGE_VAL if nothing tells. root: of a file system with proc and sys, which tests lay
// out themselves.
[[nodiscard]] double free_memory(const std::filesystem::path& root = "/");

// Bytes of the machine that this process has taken; 0 if the system does not tell.
[[nodiscard]] double taken_memory();

// Throws Error (environment) if there is no room for so many bytes: "no memory for WHAT (129700 MiB, 22839 free);
// REMEDY". What is small is not looked at.
void require_memory(double bytes, const std::string& what, const std::string& remedy);

}  // namespace assur
