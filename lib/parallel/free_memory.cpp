#include "parallel/free_memory.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <locale>

#include "assur/status.hpp"
#include "parallel/cgroup.hpp"

namespace assur {
namespace {

constexpr double kSmall = 16e6;  // bytes; the query takes 0.1 ms, and every machine has this much

// "MemAvailable:   23948120 kB"
double available(const std::filesystem::path& root) {
  std::ifstream file(root / "proc/meminfo");
  file.imbue(std::locale::classic());
  std::string name, unit;
  for (double value = 0; file >> name >> value;) {
    if (name == "MemAvailable:") return 1024 * value;
    std::getline(file, unit);
  }
  return HUGE_VAL;
}

enum StatmField : int { kSize = 0, kResident = 1, kData = 5 };

// Bytes; 0 if the system does not report it.
double statm(const std::filesystem::path& root, StatmField field) {
  std::ifstream file(root / "proc/self/statm");
  file.imbue(std::locale::classic());
  double pages = 0;
  for (int i = 0; i <= field; ++i) file >> pages;
  return file ? pages * static_cast<double>(sysconf(_SC_PAGESIZE)) : 0;
}

double below_limit(const std::filesystem::path& root, int resource, StatmField taken) {
  rlimit limit{};
  if (getrlimit(static_cast<__rlimit_resource>(resource), &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) {
    return HUGE_VAL;
  }
  return std::max(0.0, static_cast<double>(limit.rlim_cur) - statm(root, taken));
}

}  // namespace

double free_memory(const std::filesystem::path& root) {
  const double group = cgroup_memory(root);
  return std::min({available(root), group > 0 ? group : HUGE_VAL, below_limit(root, RLIMIT_AS, kSize),
                   below_limit(root, RLIMIT_DATA, kData)});
}

double taken_memory() { return statm("/", kResident); }

void require_memory(double bytes, const std::string& what, const std::string& remedy) {
  if (bytes < kSmall) return;
  const double free = free_memory();
  if (bytes < free) return;
  const auto mebibytes = [](double b) { return std::to_string(std::llround(b / 1048576)); };
  throw Error(Error::Kind::environment,
              "no memory for " + what + " (" + mebibytes(bytes) + " MiB, " + mebibytes(free) + " free); " + remedy);
}

}  // namespace assur
