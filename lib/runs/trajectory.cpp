#include <bit>
#include <charconv>
#include <cmath>
#include <ostream>

#include "assur/ensemble.hpp"
#include "assur/simulator.hpp"
#include "outputs/columns.hpp"

namespace assur {

std::size_t Trajectory::index(std::string_view column) const { return column_index(columns_, column); }

double Trajectory::last(std::string_view column) const {
  const std::size_t c = index(column);
  if (rows() == 0) throw Error(Error::Kind::input, "the trajectory has no rows: the run did not reach its first time");
  return (*this)(rows() - 1, c);
}

std::vector<double> Trajectory::column(std::string_view column) const {
  std::vector<double> out;
  out.reserve(rows());
  for (std::size_t i = index(column); i < values_.size(); i += columns_.size()) out.push_back(values_[i]);
  return out;
}

namespace {

// Lines of a CSV. A number is the shortest text that reads back as the same number; NaN is an empty field.
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

namespace {

// Numbers of a file in NumPy's format, in the order of bytes of this machine.
class NpyNumbers {
 public:
  NpyNumbers(std::ostream& out, const std::vector<std::string>& columns, const std::string& shape,
             const NpyOptions& options)
      : out_(out), single_(options.single) {
    if (options.every < 1) throw Error(Error::Kind::input, "NpyOptions::every must be at least 1");
    const std::string type =
        std::string(std::endian::native == std::endian::little ? "<f" : ">f") + (single_ ? "4" : "8");
    std::string header = "{'descr': [('t', '" + type + "')";
    for (const std::string& column : columns) header += ", ('" + column + "', '" + type + "')";
    header += "], 'fortran_order': False, 'shape': (" + shape + "), }";
    // The numbers begin at a multiple of 64 bytes; the header ends with a line feed.
    const bool is_long = header.size() > 65'000;
    const std::size_t before = is_long ? 12 : 10, size = (before + header.size()) / 64 * 64 + 64 - before;
    header.resize(size - 1, ' ');
    out_ << "\x93NUMPY" << (is_long ? '\2' : '\1') << '\0';
    for (int byte = 0; byte < (is_long ? 4 : 2); ++byte) out_.put(static_cast<char>(size >> (8 * byte) & 0xff));
    out_ << header << '\n';
  }

  void put(double number) {
    const auto write = [&](auto value) { out_.write(reinterpret_cast<const char*>(&value), sizeof value); };
    if (single_) return write(static_cast<float>(number));
    write(number);
  }
  void put(double time, std::span<const double> row) {
    put(time);
    for (const double x : row) put(x);
  }

 private:
  std::ostream& out_;
  bool single_;
};

std::size_t kept(std::size_t rows, const NpyOptions& options) {
  return options.every < 1 ? 0 : (rows + options.every - 1) / options.every;
}

}  // namespace

void write_npy(std::ostream& out, const Trajectory& trajectory, const NpyOptions& options) {
  NpyNumbers numbers(out, trajectory.columns(), std::to_string(kept(trajectory.rows(), options)) + ",", options);
  for (std::size_t k = 0; k < trajectory.rows(); k += options.every)
    numbers.put(trajectory.times()[k], trajectory.row(k));
}

void write_npy(std::ostream& out, const EnsembleTrajectory& trajectory, const NpyOptions& options) {
  const std::vector<double>& times = trajectory.times();
  const std::string shape = std::to_string(trajectory.members()) + ", " + std::to_string(kept(times.size(), options));
  NpyNumbers numbers(out, trajectory.columns(), shape, options);
  for (std::size_t i = 0; i < trajectory.members(); ++i) {
    for (std::size_t k = 0; k < times.size(); k += options.every) numbers.put(times[k], trajectory.row(i, k));
  }
}

}  // namespace assur
