#include "measure/noise.hpp"

#include <cstdio>
#include <fstream>
#include <utility>

namespace assur::measure {
namespace {

// Figures above which a measurement has some noise, or is noisy. A median over rounds tolerates one disturbed round in
// five; at a load of one half, every other processor is busy with other programs.
struct Threshold {
  double Noise::*what;
  double some, much;
  double unit;
  const char* says;
};
constexpr Threshold kThresholds[] = {
    {&Noise::load, 0.25, 0.75, 1, "the load before the run was %.1f for each processor"},
    {&Noise::stolen, 0.01, 0.05, 100, "the hypervisor took %.0f %% of the time"},
    {&Noise::disturbed, 0.02, 0.10, 100, "the system interrupted %.0f %% of the measurements"},
    {&Noise::uneven, 0.1, 0.9, 100,
     "one core was slower than another in %.0f %% of the measurements with several threads, which were repeated"},
    {&Noise::scatter, 0.02, 0.05, 100, "times scatter by %.0f %%"},
    {&Noise::drift, 0.1, 0.5, 100,
     "the whole machine was at times up to %.0f %% slower, for which times are corrected"},
};

void read_ticks(const std::filesystem::path& root, double& total, double& stolen) {
  std::ifstream file(root / "proc/stat");
  std::string word;
  file >> word;  // "cpu", then user, nice, system, idle, iowait, irq, softirq, steal; guests are part of user
  total = stolen = 0;
  double ticks = 0;
  for (int i = 0; i < 8 && file >> ticks; ++i) {
    total += ticks;
    if (i == 7) stolen = ticks;
  }
}

}  // namespace

NoiseWatch::NoiseWatch(int processors, std::filesystem::path root) : root_(std::move(root)) {
  std::ifstream(root_ / "proc/loadavg") >> load_;
  load_ /= processors;
  read_ticks(root_, total_, stolen_);
}

Noise NoiseWatch::noise() const {
  double total = 0, stolen = 0;
  read_ticks(root_, total, stolen);
  Noise out;
  out.load = load_;
  if (total > total_) out.stolen = (stolen - stolen_) / (total - total_);
  return out;
}

NoiseAssessment assess(const Noise& noise) {
  NoiseAssessment out;
  for (const Threshold& t : kThresholds) {
    const double value = noise.*t.what;
    if (value < t.some) continue;
    if (out.quiet != Quiet::noisy) out.quiet = value < t.much ? Quiet::some_noise : Quiet::noisy;
    char text[160];
    std::snprintf(text, sizeof text, t.says, t.unit * value);
    out.reason += (out.reason.empty() ? "" : "; ") + std::string(text);
  }
  return out;
}

}  // namespace assur::measure
