// A machine in the database: the properties that times depend on, and its fingerprint.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "assur/machine.hpp"

namespace assur::db {

struct Host {
  Machine machine;  // read without hwloc, which takes too long
  // Of the first processor, from /proc/cpuinfo; "" and -1 if unknown.
  std::string vendor;  // "GenuineIntel"; ARM: the implementer
  std::int32_t family = -1, model = -1, stepping = -1;
  std::string microcode;    // may change with an update: not part of the fingerprint
  std::int64_t memory = 0;  // bytes; not part of the fingerprint

  // 16 hexadecimal digits over the properties that times depend on: processor, instructions, cores, quota, caches,
  // nodes.
  [[nodiscard]] std::string fingerprint() const;
};

// Reads the properties of this machine; takes some 0.5 ms.
[[nodiscard]] Host this_host();

// root: root of a file system with proc and sys; allowed: processors of the affinity mask.
[[nodiscard]] Host read_host(const std::filesystem::path& root, const std::vector<int>& allowed,
                             const std::string& omp_num_threads);

// Similarity of two machines, from the best to the worst: are measurements of one valid for the other?
enum class Likeness : std::uint8_t {
  same,               // same fingerprint
  processor,          // same processor; other cores, quota, caches, or memory nodes
  microarchitecture,  // same vendor, family and model
  none,
};

[[nodiscard]] Likeness likeness(const Host& a, const Host& b);

// "AMD EPYC 9B14 (AuthenticAMD 25/17/1), AVX3_ZEN4, 2 cores, quota 1.5"
[[nodiscard]] std::string to_string(const Host& host);

}  // namespace assur::db
