#include "motion/function_check.hpp"

#include <algorithm>
#include <cmath>

#include "index.hpp"
#include "joints/gear.hpp"

namespace assur {
namespace {

// Steps between checks. A step calls a callback at least six times and a law at least once; a check calls them six and
// four times.
constexpr std::int64_t kCallbackInterval = 16;
constexpr std::int64_t kLawInterval = 64;
constexpr std::int64_t kLater = 4;  // factor of the interval after a closer look that found no contradiction

double relative(const Contradiction& c) {
  return std::abs(c.given - c.found) / std::max(std::abs(c.given), std::abs(c.found));
}

}  // namespace

FunctionCheck::FunctionCheck(const Structure& structure, const System& system, std::span<const std::int32_t> address)
    : system_(system), address_(address) {
  for (const CallbackBlock& block : system.callbacks) {
    if (!numbers_of(*block.callback)) add_callback(structure, block);  // no gear
  }
  for_each_function(system, [&](std::size_t i, std::size_t k, const Law::Function& law) {
    laws_.push_back({i, k, &law, law_unit(system, system.inputs[i], k), {kLawInterval}});
  });
  if (!laws_.empty()) derivatives_ = wanted_derivatives(system);
}

// Checks a callback only if its arguments are computed, and its curvature only if their accelerations are wanted.
void FunctionCheck::add_callback(const Structure& structure, const CallbackBlock& block) {
  std::vector<std::uint8_t> accelerated(system_.coordinates.size(), 0);
  for (const Group& g : structure.groups) {
    for (const std::int32_t u : g.unknowns) accelerated[idx(u)] = g.wanted_derivatives == 2 ? 1 : 0;
  }
  for (const std::int32_t c : structure.static_coordinates) accelerated[idx(c)] = 1;
  bool curvature = true;
  for (const Index form : block.coordinates) {
    for (const Term& t : system_.form(form)) {
      if (address_[idx(t.coordinate)] < 0) return;
      const bool known = system_.coordinates[idx(t.coordinate)].role != Role::unknown;
      curvature = curvature && (known || accelerated[idx(t.coordinate)] != 0);
    }
  }
  callbacks_.push_back({&block, check_of(system_, block), curvature, {kCallbackInterval}});
}

void FunctionCheck::restart() {
  steps_ = 0;
  for (OfCallback& c : callbacks_) c.when = {kCallbackInterval};
  for (OfLaw& l : laws_) l.when = {kLawInterval};
}

void FunctionCheck::Schedule::passed(std::int64_t step, bool closely) {
  if (closely) interval *= kLater;
  next = step + interval;
}

bool FunctionCheck::contradicts(OfCallback& c, const double* const (&state)[3]) {
  for (std::size_t j = 0; j < c.check.x.size(); ++j) {
    double value = 0, rate = 0;
    for (const Term& t : system_.form(c.block->coordinates[j])) {
      const double factor = system_.constants[idx(t.constant)];
      value += factor * state[0][address_[idx(t.coordinate)]];
      rate += factor * state[1][address_[idx(t.coordinate)]];
    }
    c.check.x[j] = value * c.block->unit[j];
    c.check.rate[j] = rate * c.block->unit[j];
  }
  const bool closely = c.check.doubtful(c.curvature, static_cast<std::uint64_t>(steps_));
  if (closely && (found_ = c.check.find(c.curvature))) return true;
  c.when.passed(steps_, closely);
  return false;
}

bool FunctionCheck::contradicts(OfLaw& l, double from, double to) {
  const bool closely = LawCheck::doubtful(*l.law, from, to, l.unit, derivatives_);
  if (closely && (found_ = law_check_.find(*l.law, from, to, l.unit, derivatives_))) return true;
  l.when.passed(steps_, closely);
  return false;
}

Event FunctionCheck::event(const OfCallback& c, double from, double to) const {
  return {from,
          to,
          system_.equation_name(c.block->first_equation),
          Code::wrong_function,
          relative(*found_),
          describe(*found_, c.block->callback)};
}

Event FunctionCheck::event(const OfLaw& l, double from, double to) const {
  const std::string& driver = system_.drivers[idx(system_.inputs[l.input].driver)];
  return {from, to, driver, Code::wrong_function, relative(*found_), describe(*found_, nullptr)};
}

}  // namespace assur
