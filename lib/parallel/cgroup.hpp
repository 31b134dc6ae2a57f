// The share of the processors' time that Linux control groups leave to this process.
#pragma once

#include <filesystem>

namespace assur {

// Processors' time for each unit of time: the least quota on the way from this process's group to the top, of cgroup v2
// (cpu.max) and v1 (cpu.cfs_quota_us). 0 if there is none, or none that can be read. root: of a file system with proc
// and sys, which tests lay out themselves.
[[nodiscard]] double cpu_quota(const std::filesystem::path& root = "/");

}  // namespace assur
