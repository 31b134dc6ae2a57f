// Energy of the processors of this machine by their own counters (RAPL, through powercap).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace assur::report {

class EnergyMeter {
 public:
  // root: root of a file system with sys/class/powercap.
  explicit EnergyMeter(const std::filesystem::path& root = "/");

  // The reason why the counters cannot be read; "": they can.
  [[nodiscard]] const std::string& why_not() const { return why_not_; }

  // Counters of the packages, µJ; empty if they cannot be read.
  [[nodiscard]] std::vector<std::int64_t> read() const;

  // Energy of all packages between two readings, J, including idle parts. Counters wrap around after some minutes of
  // full load. NaN if a reading is missing.
  [[nodiscard]] double joules(const std::vector<std::int64_t>& from, const std::vector<std::int64_t>& to) const;

 private:
  struct Package {
    std::filesystem::path counter;
    std::int64_t range;  // µJ, at which the counter wraps around
  };
  std::vector<Package> packages_;
  std::string why_not_;
};

}  // namespace assur::report
