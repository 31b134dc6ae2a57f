// What the handles of assur.h hold, and how its functions end.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "assur/assur.h"
#include "assur/ensemble.hpp"
#include "assur/plan.hpp"
#include "assur/simulator.hpp"

struct assur_plan {
  assur::Prepared prepared;
};

struct assur_simulator {
  explicit assur_simulator(assur::Simulator of) : simulator(std::move(of)), driver_names(simulator.drivers()) {
    for (const std::string& name : driver_names) drivers.push_back(simulator.driver(name));
  }
  assur::Simulator simulator;
  std::vector<std::string> driver_names;
  std::vector<assur::DriverHandle> drivers;
  std::vector<std::string> slopes;  // rows of the Jacobian; empty before they are asked for
};

struct assur_state {
  assur::SimulatorState state;
};

struct assur_ensemble {
  assur::Ensemble ensemble;
  std::size_t values_of_member = 0;  // columns of the table of parameters; 0: there is none
};

namespace assur::c {

// Keeps the text of the exception in flight for assur_error(), and returns its kind.
[[nodiscard]] std::int32_t failed() noexcept;

// Calls work(), which returns a result, and turns exceptions into results.
template <class Work>
std::int32_t call(const Work& work) noexcept {
  try {
    return work();
  } catch (...) {
    return failed();
  }
}

// Throws Error (input): "`name` is NULL".
[[noreturn]] void refuse_null(const char* name);

template <class T>
T& checked(T* pointer, const char* name) {
  if (pointer == nullptr) refuse_null(name);
  return *pointer;
}

// Throws Error (input) for NULL and for a NULL among the texts, unless count is 0.
[[nodiscard]] std::vector<std::string> texts(const char* const* from, std::size_t count, const char* name);

// A struct of the caller with a size: members that it lacks have the values of `defaults`. Throws Error (input) if no
// version of the struct has this size, which would cut a pointer. NULL: the defaults.
template <class Struct>
Struct sized(const Struct* from, const Struct& defaults, const char* name) {
  static_assert(std::is_trivially_copyable_v<Struct>);
  Struct out = defaults;
  if (from == nullptr) return out;
  if (from->size < sizeof(std::size_t) || from->size > sizeof(Struct) || from->size % alignof(Struct) != 0) {
    throw Error(Error::Kind::input, std::string(name) + ": size is " + std::to_string(from->size) +
                                        "; set it to sizeof, which is at most " + std::to_string(sizeof(Struct)) +
                                        " in this library");
  }
  std::memcpy(&out, from, from->size);
  return out;
}
// Writes a struct to that of the caller, whose size may be smaller.
template <class Struct>
void give(const Struct& value, Struct* to, const char* name) {
  const std::size_t size = sized(&checked(to, name), value, name).size;
  std::memcpy(to, &value, size);
  to->size = size;
}

inline std::int32_t give(const Status& status, assur_status* to) noexcept {
  const auto code = static_cast<std::int32_t>(status.code);
  if (to != nullptr) *to = {code, static_cast<std::int32_t>(status.where.kind), status.where.index, 0, status.figure};
  return code;
}

[[nodiscard]] StepSettings settings_of(const assur_step_settings* settings);

// Throws Error (input), which names `what`, if `count` items `stride` numbers apart exceed any memory.
void check_extent(const char* what, std::size_t count, std::size_t stride);
// The same, which names the stride; also if the items, of `width` numbers, would overlap.
void check_stride(const char* name, std::size_t stride, std::size_t count, std::size_t width);

// The times of a run: those of the caller, or the time grid if they are NULL.
[[nodiscard]] std::vector<double> times_of(const double* times, std::size_t count, const TimeGrid& grid);

// The table of parameters: members x width. Throws Error (input) for a stride below the width.
[[nodiscard]] std::vector<double> table_of(const double* values, std::size_t members, std::size_t member_stride,
                                           std::size_t width);

// NULL if there is no such name.
inline const char* name_at(const std::vector<std::string>& names, std::size_t i) {
  return i < names.size() ? names[i].c_str() : nullptr;
}

}  // namespace assur::c
