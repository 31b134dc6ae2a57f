#include "dispatch/impossible.hpp"

#include <cmath>
#include <cstdint>

namespace assur {
namespace {

constexpr std::int64_t kMostOperations = 1'000'000'000'000'000;  // of one call; a day's work of one core

bool is_size(std::int64_t size) { return size >= 0 && size <= kMostOperations; }
bool is_error(double error) { return std::isnan(error) || error >= 0; }

}  // namespace

std::string_view why_impossible(const Sample& sample) {
  if (!is_possible_time(sample.seconds)) return "its time must be 1e-15 to 1e9 s";
  if (!(sample.spread >= 0 && sample.spread <= kMostTime)) return "its spread must be 0 to 1e9 s";
  if (sample.repetitions < 0) return "its repetitions must not be negative";
  if (!is_error(sample.backward_error) || !is_error(sample.forward_error)) return "its errors must not be negative";
  const Shape& s = sample.shape;
  for (const std::int64_t size : {std::int64_t{s.n}, std::int64_t{s.nnz}, std::int64_t{s.groups}, std::int64_t{s.rhs},
                                  s.fill, s.operations, s.depth, s.terms}) {
    if (!is_size(size)) return "the sizes of its shape must be 0 to 1e15";
  }
  return "";
}

}  // namespace assur
