#include <cstdint>
#include <sstream>
#include <vector>

#include "assur/saved_plan.hpp"
#include "assur/simulator.hpp"
#include "fuzz/targets.hpp"

namespace assur::fuzz {
namespace {

// The text with a valid checksum (FNV-1a).
std::string signed_again(std::string_view bytes) {
  std::string text(bytes.substr(0, bytes.rfind("checksum ")));
  if (!text.ends_with('\n')) text += '\n';
  std::uint64_t hash = 14695981039346656037u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  text += "checksum ";
  for (int shift = 60; shift >= 0; shift -= 4) text += "0123456789abcdef"[hash >> shift & 15];
  return text + '\n';
}

// Runs an accepted plan. The motion may differ or end with a status, but must not access foreign memory.
bool take(std::string text) {
  return accepts([&] {
    std::istringstream in(std::move(text));
    Prepared prepared = load_plan(in, {.budget = ThreadBudget{1}});
    const double step = prepared.time().step;
    Simulator simulator(std::move(prepared));
    const double t = simulator.time();
    (void)simulator.run(std::vector<double>{t, t + step, t + 2 * step, t + 3 * step});
  });
}

}  // namespace

bool plan(std::string_view bytes) {
  const bool as_it_is = take(std::string(bytes));
  return take(signed_again(bytes)) || as_it_is;
}

}  // namespace assur::fuzz
