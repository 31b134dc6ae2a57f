// Disturbances of the machine during measurements.
#pragma once

#include <filesystem>
#include <string>

namespace assur::measure {

// Disturbances; all 0 on an otherwise idle machine.
struct Noise {
  double load = 0;       // load by other programs, per processor: average of the minute before
  double stolen = 0;     // share of the processors' time that the hypervisor gave to others
  double disturbed = 0;  // share of the timed blocks during which the system took the processor away
  double uneven = 0;     // share of the blocks of several threads while one core was much slower than another
  double scatter = 0;    // median of spread / time over all samples
  double drift = 0;      // relative change of the pace of the machine during the measurements
};

// Observes the machine from construction on. Figures that the system does not report are 0.
class NoiseWatch {
 public:
  // root: root of a file system with proc; processors: divisor of the load.
  explicit NoiseWatch(int processors, std::filesystem::path root = "/");

  // Load and stolen time until now.
  [[nodiscard]] Noise noise() const;

 private:
  std::filesystem::path root_;
  double load_ = 0;
  double total_ = 0, stolen_ = 0;  // ticks since the system started
};

enum class Quiet { yes, some_noise, noisy };

struct NoiseAssessment {
  Quiet quiet = Quiet::yes;
  std::string reason;  // "" if quiet
};

[[nodiscard]] NoiseAssessment assess(const Noise& noise);

}  // namespace assur::measure
