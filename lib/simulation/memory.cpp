#include "simulation/memory.hpp"

#include <unistd.h>

#include <cmath>
#include <string>

#include "assur/status.hpp"

namespace assur {

void check_memory(std::size_t rows, std::size_t columns) {
  const double wanted = static_cast<double>(rows) * static_cast<double>(columns) * sizeof(double);
  const double free = static_cast<double>(sysconf(_SC_AVPHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  if (wanted < free) return;
  throw Error(Error::Kind::environment,
              "no memory for " + std::to_string(rows) + " times x " + std::to_string(columns) + " values (" +
                  std::to_string(std::llround(wanted / 1048576)) + " MiB, " +
                  std::to_string(std::llround(free / 1048576)) + " free); ask for fewer outputs or a shorter run");
}

}  // namespace assur
