// The energy that the processors of this machine have taken, as they count it themselves (RAPL, through powercap).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace assur::report {

class EnergyMeter {
 public:
  // root: of a file system with sys/class/powercap.
  explicit EnergyMeter(const std::filesystem::path& root = "/");

  // Why nothing can be read; "": it can.
  [[nodiscard]] const std::string& why_not() const { return why_not_; }

  // Counters of the packages, in µJ; empty where they cannot be read.
  [[nodiscard]] std::vector<std::int64_t> read() const;

  // Energy of all packages between two readings, J, idle parts included: counters begin anew at their range, which is
  // some minutes of full load apart. NaN if a reading is missing.
  [[nodiscard]] double joules(const std::vector<std::int64_t>& from, const std::vector<std::int64_t>& to) const;

 private:
  struct Package {
    std::filesystem::path counter;
    std::int64_t range;  // µJ, at which the counter begins anew
  };
  std::vector<Package> packages_;
  std::string why_not_;
};

}  // namespace assur::report
