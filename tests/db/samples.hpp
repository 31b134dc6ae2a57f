// Samples and machines for tests of the database.
#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "assur/performance.hpp"
#include "db/host.hpp"
#include "db/store.hpp"

namespace assur::test {

inline db::Host host_with(std::int32_t cores, double quota = 0) {
  db::Host host;
  host.vendor = "MakerOfProcessors";
  host.family = 25;
  host.model = 17;
  host.stepping = 1;
  host.machine.model = "Fast One";
  host.machine.instructions = "AVX2";
  for (std::int32_t core = 0; core < cores; ++core) host.machine.cores.push_back(core);
  host.machine.processors = 2 * cores;
  host.machine.quota = quota;
  host.machine.caches = {{1, 48 << 10, 1}, {2, 1 << 20, 1}, {3, 16 << 20, 2}};
  host.microcode = "0x17";
  host.memory = std::int64_t{16} << 30;
  return host;
}

// A sample whose shape depends on `number`, so that samples differ.
inline Sample sample_of(std::int32_t number, const std::string& backend = "eigen", Kernel kernel = Kernel::factor) {
  Sample s;
  s.uid = db::new_uid();
  s.kernel = kernel;
  s.shape.n = 3 + number;
  s.shape.nnz = 3 * s.shape.n;
  s.shape.fill = 5 * s.shape.n;
  s.shape.operations = std::int64_t{1} << (number % 40);
  s.shape.depth = 2 * s.shape.n;
  s.shape.pattern = 0x9e3779b97f4a7c15u * static_cast<std::uint64_t>(number + 1);
  s.shape.one_program = number % 2 == 1;
  s.strategy.solver.backend = backend;
  s.seconds = 1e-6 / 3 * s.shape.n;
  s.spread = 1e-9 / 7;
  s.repetitions = 100 + number;
  s.backward_error = 1.1e-16 * (1 + number);
  s.forward_error = std::numeric_limits<double>::quiet_NaN();
  return s;
}

inline std::vector<Sample> cell_of(std::int32_t number, int size) {
  std::vector<Sample> cell;
  for (int i = 0; i < size; ++i) cell.push_back(sample_of(number * size + i));
  return cell;
}

// Like ==, but NaN equals NaN.
inline bool same(const Sample& a, const Sample& b) {
  const auto number = [](double x) { return std::isnan(x) ? -1 : x; };
  Sample c = a, d = b;
  for (Sample* s : {&c, &d}) {
    s->backward_error = number(s->backward_error);
    s->forward_error = number(s->forward_error);
  }
  return c == d;
}

inline std::map<std::string, Sample> by_uid(const std::vector<Sample>& samples) {
  std::map<std::string, Sample> map;
  for (const Sample& sample : samples) map[sample.uid] = sample;
  return map;
}

// Creates a database with one finished run; returns its samples.
inline std::vector<Sample> make_database(const std::filesystem::path& file, const db::Host& host, int samples,
                                         const std::string& backend = "eigen") {
  db::Store store(file, db::Access::write);
  const std::int64_t run = store.begin_run(host, "quick");
  std::vector<Sample> all;
  for (int i = 0; i < samples; ++i) all.push_back(sample_of(i, backend));
  store.add(run, all);
  store.finish_run(run, {});
  return all;
}

inline std::string bytes(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

inline void write_bytes(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary | std::ios::trunc) << text;
}

}  // namespace assur::test
