// Limits of Linux control groups for this process: processor time and memory.
#pragma once

#include <filesystem>

namespace assur {

// Number of processors that the quota allows, e.g. 1.5: the least quota of the group of this process and the groups
// above it, in cgroup v2 (cpu.max) and v1 (cpu.cfs_quota_us). 0 if there is no readable quota. root: root of a file
// system with proc and sys; tests provide their own.
[[nodiscard]] double cpu_quota(const std::filesystem::path& root = "/");

// Bytes that may still be allocated: the least difference of limit (memory.max, memory.limit_in_bytes) and use among
// these groups. 0 if there is no readable limit; at least 1 if there is one.
[[nodiscard]] double cgroup_memory(const std::filesystem::path& root = "/");

}  // namespace assur
