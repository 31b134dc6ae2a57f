#include <algorithm>
#include <charconv>
#include <cmath>
#include <ostream>

#include "assur/ensemble.hpp"
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

namespace {

// Lines of a CSV; numbers as the shortest text that reads back the same, nothing for none.
class Lines {
 public:
  explicit Lines(std::ostream& out) : out_(out) {}
  template <class Number>
  void put(Number value) {
    char number[32];
    if (!line_.empty()) line_ += ',';
    line_.append(number, std::to_chars(number, number + sizeof number, value).ptr);
  }
  void put(std::span<const double> values) {
    for (const double v : values) {
      if (std::isnan(v)) {
        line_ += ',';
      } else {
        put(v);
      }
    }
  }
  void end() {
    line_ += '\n';
    out_ << line_;
    line_.clear();
  }

 private:
  std::ostream& out_;
  std::string line_;
};

}  // namespace

void write_csv(std::ostream& out, const Trajectory& trajectory) {
  out << 't';
  for (const std::string& c : trajectory.columns()) out << ',' << c;
  out << '\n';
  Lines lines(out);
  for (std::size_t k = 0; k < trajectory.rows(); ++k) {
    lines.put(trajectory.times()[k]);
    lines.put(trajectory.row(k));
    lines.end();
  }
}

void write_csv(std::ostream& out, const EnsembleTrajectory& trajectory) {
  out << "member,t";
  for (const std::string& c : trajectory.columns()) out << ',' << c;
  out << '\n';
  Lines lines(out);
  for (std::size_t member = 0; member < trajectory.members(); ++member) {
    for (std::size_t k = 0; k < trajectory.rows(member); ++k) {
      lines.put(member + 1);
      lines.put(trajectory.times()[k]);
      lines.put(trajectory.row(member, k));
      lines.end();
    }
  }
}

}  // namespace assur
