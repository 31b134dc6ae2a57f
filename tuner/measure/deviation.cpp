#include "measure/deviation.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>

#include "numbers.hpp"

namespace assur::measure {
namespace {

// Values, velocities or accelerations of points and vectors, or values of measures. Errors of a kind are relative to
// its largest value: a coordinate near zero is as uncertain as its neighbours.
std::string kind_of(const std::string& column) {
  const std::string last = column.substr(column.rfind('.') + 1);
  return last == "x" || last == "y" || last == "z" ? "x" : last.size() == 2 ? last.substr(0, 1) : last;
}

}  // namespace

double deviation(const std::vector<std::string>& columns, std::span<const double> a, std::span<const double> b) {
  if (a.size() != b.size() || a.empty()) return kInfinity;
  if (std::memcmp(a.data(), b.data(), a.size_bytes()) == 0) return 0;
  struct Kind {
    double off = 0, largest = 0;
  };
  std::map<std::string, Kind> kinds;
  std::vector<Kind*> kind;
  for (const std::string& column : columns) kind.push_back(&kinds[kind_of(column)]);
  for (std::size_t i = 0; i < a.size(); ++i) {
    Kind& k = *kind[i % kind.size()];
    const double off = std::abs(a[i] - b[i]);
    if (!(off <= k.off)) k.off = off;
    k.largest = std::max(k.largest, std::abs(b[i]));
  }
  double worst = std::numeric_limits<double>::denorm_min();  // 0 and -0 differ
  for (const auto& [name, k] : kinds) {
    const double relative = k.largest > 0 ? k.off / k.largest : k.off;
    if (!(relative <= worst)) worst = relative;
  }
  return worst;
}

}  // namespace assur::measure
