#include <fstream>
#include <memory>
#include <optional>
#include <sstream>

#include "assur/saved_plan.hpp"
#include "c/handles.hpp"

using namespace assur;
using assur::c::call;
using assur::c::checked;

namespace {

LoadOptions options_of(std::int32_t threads) {
  LoadOptions options;
  if (threads != 0) options.budget = ThreadBudget{threads};  // a negative number is refused
  return options;
}

}  // namespace

extern "C" {

std::int32_t assur_plan_load(const char* file, std::int32_t threads, assur_plan** plan) {
  return call([&] {
    assur_plan*& out = checked(plan, "plan");
    std::ifstream in(&checked(file, "file"));
    if (!in) throw Error(Error::Kind::environment, std::string(file) + " cannot be read");
    out = new assur_plan{load_plan(in, options_of(threads))};
    return ASSUR_OK;
  });
}

std::int32_t assur_plan_read(const char* text, std::size_t length, std::int32_t threads, assur_plan** plan) {
  return call([&] {
    assur_plan*& out = checked(plan, "plan");
    std::istringstream in(std::string(&checked(text, "text"), length));
    out = new assur_plan{load_plan(in, options_of(threads))};
    return ASSUR_OK;
  });
}

std::int32_t assur_plan_save(const assur_plan* plan, const char* file) {
  return call([&] {
    const Prepared& prepared = checked(plan, "plan").prepared;
    std::ofstream out(&checked(file, "file"));
    if (!out) throw Error(Error::Kind::environment, std::string(file) + " cannot be written");
    save_plan(out, prepared);
    out.close();
    if (!out) throw Error(Error::Kind::environment, std::string(file) + " cannot be written");
    return ASSUR_OK;
  });
}

void assur_plan_free(assur_plan* plan) { delete plan; }

const char* assur_plan_name(const assur_plan* plan) {
  return plan != nullptr ? plan->prepared.name().c_str() : nullptr;
}

std::int32_t assur_plan_time(const assur_plan* plan, double* start, double* end, double* step) {
  return call([&] {
    const TimeGrid& grid = checked(plan, "plan").prepared.time();
    if (start != nullptr) *start = grid.start;
    if (end != nullptr) *end = grid.end;
    if (step != nullptr) *step = grid.step;
    return ASSUR_OK;
  });
}

}  // extern "C"
