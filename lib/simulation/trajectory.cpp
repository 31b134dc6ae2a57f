#include <algorithm>
#include <charconv>
#include <ostream>

#include "assur/simulator.hpp"

namespace assur {

std::size_t Trajectory::index(std::string_view column) const {
  const auto found = std::find(columns_.begin(), columns_.end(), column);
  if (found == columns_.end()) {
    std::string known;
    for (const std::string& c : columns_) {
      if (known.size() > 400) {
        known += ", ...";
        break;
      }
      known += (known.empty() ? "" : ", ") + c;
    }
    throw Error(Error::Kind::input, "no column '" + std::string(column) + "'; there are: " + known);
  }
  return static_cast<std::size_t>(found - columns_.begin());
}

void write_csv(std::ostream& out, const Trajectory& trajectory) {
  out << 't';
  for (const std::string& c : trajectory.columns()) out << ',' << c;
  out << '\n';
  std::string line;
  char number[32];
  const auto put = [&](double v) {
    const auto end = std::to_chars(number, number + sizeof number, v).ptr;  // shortest text that reads back the same
    line.append(number, end);
  };
  for (std::size_t k = 0; k < trajectory.rows(); ++k) {
    line.clear();
    put(trajectory.times()[k]);
    for (const double v : trajectory.row(k)) {
      line += ',';
      put(v);
    }
    line += '\n';
    out << line;
  }
}

}  // namespace assur
