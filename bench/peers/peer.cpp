#include "peer.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iostream>
#include <sstream>
#include <stdexcept>

namespace peers {
namespace {

// Reads lines of numbers: t, then three vectors of equal length.
std::vector<Row> read(const std::string& file) {
  std::ifstream stream(file);
  std::vector<Row> rows;
  for (std::string line; std::getline(stream, line);) {
    std::istringstream numbers(line);
    Row row;
    numbers >> row.t;
    std::vector<double> all;
    for (double value = 0; numbers >> value;) all.push_back(value);
    const auto third = static_cast<std::ptrdiff_t>(all.size() / 3);
    row.position.assign(all.begin(), all.begin() + third);
    row.velocity.assign(all.begin() + third, all.begin() + 2 * third);
    row.acceleration.assign(all.begin() + 2 * third, all.end());
    rows.push_back(std::move(row));
  }
  if (rows.size() < 2) throw std::runtime_error(file + " is not a reference");
  return rows;
}

double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double error(const std::vector<Row>& found, const std::vector<Row>& reference, std::vector<double> Row::*level) {
  double off = 0, size = 0;
  for (std::size_t k = 0; k < reference.size(); ++k) {
    const std::vector<double>&x = found[k].*level, &y = reference[k].*level;
    for (std::size_t i = 0; i < y.size(); ++i) {
      // NaN counts as the largest error.
      const double d = std::abs(x[i] - y[i]);
      off = d <= off ? off : d;
      size = std::max(size, std::abs(y[i]));
    }
  }
  return off / size;
}

void follow(const std::string& mechanism, const std::string& file, const PeerInfo& info) {
  const std::vector<Row> reference = read(file);
  const std::size_t colon = mechanism.find(':');
  const int loops = colon == std::string::npos ? 1 : std::stoi(mechanism.substr(colon + 1));
  const auto peer = info.make(mechanism.substr(0, colon), loops, reference.front());
  std::vector<Row> found = reference;  // has the sizes of the reference; its first row stays
  for (std::size_t k = 1; k < found.size(); ++k) {
    for (auto level : {&Row::position, &Row::velocity, &Row::acceleration}) {
      std::fill((found[k].*level).begin(), (found[k].*level).end(), std::nan(""));
    }
  }
  const double begin = processor_seconds();
  for (std::size_t k = 1; k < found.size(); ++k) peer->step(reference[k].t, found[k]);
  const double taken = processor_seconds() - begin;

  const std::size_t steps = found.size() - 1;
  std::printf("%s,%s,%d,%zu,%.6g", info.name, mechanism.c_str(), info.levels, steps,
              taken / static_cast<double>(steps));
  int level = 0;
  for (auto values : {&Row::position, &Row::velocity, &Row::acceleration}) {
    if (level++ < info.levels) {
      std::printf(",%.3g", error(found, reference, values));
    } else {
      std::printf(",");
    }
  }
  std::printf(",%s\n", info.comment);
}

}  // namespace

int run(int argc, char** argv, const PeerInfo& info) {
  if (argc == 2 && std::strcmp(argv[1], "header") == 0) {
    std::puts("peer,mechanism,levels,steps,seconds_per_step,position_error,velocity_error,acceleration_error,comment");
    return 0;
  }
  if (argc != 3) {
    std::cerr << "usage: " << argv[0] << " MECHANISM REFERENCE\n";
    return 2;
  }
  try {
    follow(argv[1], argv[2], info);
    return 0;
  } catch (const std::exception& e) {
    std::cerr << info.name << ", " << argv[1] << ": " << e.what() << '\n';
    return 1;
  }
}

}  // namespace peers
