// What Linux control groups leave to this process: a share of the processors' time, and memory.
#pragma once

#include <filesystem>

namespace assur {

// Processors' time for each unit of time: the least quota on the way from this process's group to the top, of cgroup v2
// (cpu.max) and v1 (cpu.cfs_quota_us). 0 if there is none, or none that can be read. root: of a file system with proc
// and sys, which tests lay out themselves.
[[nodiscard]] double cpu_quota(const std::filesystem::path& root = "/");

// Bytes that may still be taken: the least on that way, of memory.max and memory.limit_in_bytes less what is in use. 0 if
// there is no limit, or none that can be read; at least 1 where there is one.
[[nodiscard]] double cgroup_memory(const std::filesystem::path& root = "/");

}  // namespace assur
