#include "c/handles.hpp"

#include <cstdint>
#include <exception>
#include <new>

namespace assur::c {
namespace {

// The last error of a thread.
struct LastError {
  std::string text;
  std::vector<Diagnostic> diagnostics;
};
LastError& last_error() {
  thread_local LastError error;
  return error;
}

std::int32_t keep(const Error& e) {
  last_error() = {e.what(), e.diagnostics()};
  switch (e.kind()) {
    case Error::Kind::input:
      return ASSUR_ERROR_INPUT;
    case Error::Kind::numerical:
      return ASSUR_ERROR_NUMERICAL;
    case Error::Kind::environment:
      return ASSUR_ERROR_ENVIRONMENT;
  }
  return ASSUR_ERROR_INTERNAL;
}

std::int32_t keep(std::int32_t kind, const std::string& text) {
  last_error() = {text, {{"", text}}};
  return kind;
}

}  // namespace

std::int32_t failed() noexcept {
  try {
    try {
      throw;
    } catch (const Error& e) {
      return keep(e);
    } catch (const std::bad_alloc&) {
      return keep(ASSUR_ERROR_ENVIRONMENT, "there is not enough memory");
    } catch (const std::exception& e) {
      return keep(ASSUR_ERROR_INTERNAL, e.what());
    } catch (...) {
      return keep(ASSUR_ERROR_INTERNAL, "an unknown exception");
    }
  } catch (...) {  // no memory for the text
    last_error().text.clear();
    last_error().diagnostics.clear();
    return ASSUR_ERROR_ENVIRONMENT;
  }
}

void refuse_null(const char* name) { throw Error(Error::Kind::input, std::string(name) + " is NULL"); }

std::vector<std::string> texts(const char* const* from, std::size_t count, const char* name) {
  std::vector<std::string> out;
  check_extent(name, count, 1);
  if (count > 0) (void)checked(from, name);
  for (std::size_t i = 0; i < count; ++i) {
    if (from[i] == nullptr) refuse_null((std::string(name) + "[" + std::to_string(i) + "]").c_str());
    out.emplace_back(from[i]);
  }
  return out;
}

StepSettings settings_of(const assur_step_settings* settings) {
  const assur_step_settings given = sized(settings, assur_step_settings ASSUR_STEP_SETTINGS, "settings");
  StepSettings out;
  out.iterations = given.iterations;
  out.most_iterations = given.most_iterations;
  out.seconds = given.seconds;
  if (given.pin_to != nullptr) out.pin_to.assign(given.pin_to, given.pin_to + given.pin_count);
  if (given.stop != nullptr) {
    out.stop = [stop = given.stop, context = given.stop_context] { return stop(context) != 0; };
  }
  return out;
}

void check_extent(const char* what, std::size_t count, std::size_t stride) {
  constexpr std::size_t kMost = PTRDIFF_MAX / sizeof(assur_summary);  // of the largest items
  if (count > kMost || stride > kMost / std::max<std::size_t>(count, 1)) {
    throw Error(Error::Kind::input, std::string(what) + ": " + std::to_string(count) + " items that are " +
                                        std::to_string(stride) + " numbers apart exceed any memory");
  }
}

void check_stride(const char* name, std::size_t stride, std::size_t count, std::size_t width) {
  check_extent(name, count, stride);
  if (stride >= width) return;
  throw Error(Error::Kind::input, std::string(name) + " is " + std::to_string(stride) + ", and must be at least " +
                                      std::to_string(width) + ": the numbers of an item");
}

std::vector<double> times_of(const double* times, std::size_t count, const TimeGrid& grid) {
  if (times != nullptr) check_extent("times", count, 1);
  if (times != nullptr) return {times, times + count};
  const auto rows = static_cast<std::size_t>(grid.steps()) + 1;
  if (rows > count) {
    throw Error(Error::Kind::input,
                "the time grid has " + std::to_string(rows) + " rows, and there is room for " + std::to_string(count));
  }
  std::vector<double> out;
  out.reserve(rows);
  for (std::size_t k = 0; k < rows; ++k) out.push_back(grid.time(static_cast<std::int64_t>(k)));
  return out;
}

std::vector<double> table_of(const double* values, std::size_t members, std::size_t member_stride, std::size_t width) {
  check_stride("member_stride", member_stride, members, width);
  if (members > 0 && width > 0) (void)checked(values, "values");
  std::vector<double> out;
  for (std::size_t i = 0; i < members; ++i) {
    out.insert(out.end(), values + i * member_stride, values + i * member_stride + width);
  }
  return out;
}

}  // namespace assur::c

using assur::c::last_error;

extern "C" {

std::int32_t assur_abi(void) { return ASSUR_ABI; }
const char* assur_version(void) { return ASSUR_VERSION; }

const char* assur_code_name(std::int32_t code) {
  const bool known = code >= 0 && code <= UINT8_MAX;
  return known ? assur::name(static_cast<assur::Code>(code)).data() : "unknown";
}
const char* assur_code_explanation(std::int32_t code) {
  const bool known = code >= 0 && code <= UINT8_MAX;
  return known ? assur::explanation(static_cast<assur::Code>(code)).data() : "unknown";
}
std::int32_t assur_arrived(std::int32_t code) { return code == ASSUR_OK || code == ASSUR_INACCURATE ? 1 : 0; }

const char* assur_error(void) { return last_error().text.c_str(); }
std::size_t assur_error_count(void) { return last_error().diagnostics.size(); }
const char* assur_error_where(std::size_t finding) {
  const auto& all = last_error().diagnostics;
  return finding < all.size() ? all[finding].where.c_str() : "";
}
const char* assur_error_what(std::size_t finding) {
  const auto& all = last_error().diagnostics;
  return finding < all.size() ? all[finding].what.c_str() : "";
}

}  // extern "C"
