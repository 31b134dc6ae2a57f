// How quiet the machine was while something was measured.
#pragma once

#include <filesystem>
#include <string>

namespace assur::measure {

// What disturbs a measurement; each 0 on a machine that does nothing else.
struct Noise {
  double load = 0;       // of other programs, for each processor: the average of the last minute before
  double stolen = 0;     // share of the processors' time that the hypervisor gave to others
  double disturbed = 0;  // share of the timed blocks during which the system took the processor away
  double uneven = 0;     // share of the blocks of several threads while one core was much slower than another
  double scatter = 0;    // median of spread / time over all samples
  double drift = 0;      // by how much the machine was slower at some times than at others, relative
};

// Watches from its construction on. What the system does not tell counts as quiet.
class NoiseWatch {
 public:
  // root: of a file system with proc; processors: that the load is for.
  explicit NoiseWatch(int processors, std::filesystem::path root = "/");

  // Load and stolen time until now.
  [[nodiscard]] Noise noise() const;

 private:
  std::filesystem::path root_;
  double load_ = 0;
  double total_ = 0, stolen_ = 0;  // ticks since the system started
};

enum class Quiet { yes, some_noise, noisy };

struct Judgement {
  Quiet quiet = Quiet::yes;
  std::string reason;  // "" if quiet
};

[[nodiscard]] Judgement judge(const Noise& noise);

}  // namespace assur::measure
