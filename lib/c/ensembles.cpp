#include <algorithm>

#include "c/handles.hpp"
#include "numbers.hpp"
#include "outputs/columns.hpp"

using namespace assur;
using assur::c::call;
using assur::c::checked;
using assur::c::give;

namespace {

constexpr std::size_t kRowsInBlock = 64;  // that are copied to the caller at once

// Names of the columns that the caller wants; NULL: all.
std::vector<std::string> names_of(const std::vector<std::string>& all, const std::size_t* columns, std::size_t count) {
  if (columns == nullptr) return all;
  c::check_extent("columns", count, 1);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < count; ++i) {
    if (columns[i] >= all.size()) {
      throw Error(Error::Kind::input, "there is no column " + std::to_string(columns[i]) + "; there are " +
                                          std::to_string(all.size()) + ", counted from 0");
    }
    names.push_back(all[columns[i]]);
  }
  if (names.empty()) throw Error(Error::Kind::input, "no column is wanted");
  return names;
}

void check_strides(std::size_t members, std::size_t rows, std::size_t columns, std::size_t member_stride,
                   std::size_t row_stride) {
  c::check_stride("row_stride", row_stride, rows, columns);
  c::check_extent("member_stride", members, member_stride);
  const bool by_rows = member_stride >= columns && row_stride / std::max<std::size_t>(members, 1) >= member_stride;
  if (members > 1 && rows > 0 && !by_rows && member_stride < (rows - 1) * row_stride + columns) {
    throw Error(Error::Kind::input, "with member_stride " + std::to_string(member_stride) + " and row_stride " +
                                        std::to_string(row_stride) + " rows would overlap");
  }
}

}  // namespace

extern "C" {

std::int32_t assur_ensemble_of_plans(const assur_plan* const* plans, std::size_t count,
                                     const assur_step_settings* settings, assur_ensemble** ensemble) {
  return call([&] {
    assur_ensemble*& out = checked(ensemble, "ensemble");
    c::check_extent("plans", count, 1);
    if (count > 0) (void)checked(plans, "plans");
    const auto member = [&](std::size_t i) { return checked(plans[i], "a plan").prepared; };
    for (std::size_t i = 0; i < count; ++i) (void)checked(plans[i], "a plan");  // no member of its own
    out = new assur_ensemble{Ensemble(count, member, c::settings_of(settings))};
    return ASSUR_OK;
  });
}

void assur_ensemble_free(assur_ensemble* ensemble) { delete ensemble; }

std::size_t assur_ensemble_members(const assur_ensemble* ensemble) {
  return ensemble != nullptr ? ensemble->ensemble.members() : 0;
}
std::size_t assur_ensemble_column_count(const assur_ensemble* ensemble) {
  return ensemble != nullptr ? ensemble->ensemble.columns().size() : 0;
}
const char* assur_ensemble_column_name(const assur_ensemble* ensemble, std::size_t column) {
  return ensemble != nullptr ? c::name_at(ensemble->ensemble.columns(), column) : nullptr;
}
std::int32_t assur_ensemble_column(const assur_ensemble* ensemble, const char* name, std::size_t* column) {
  return call([&] {
    std::size_t& out = checked(column, "column");
    out = column_index(checked(ensemble, "ensemble").ensemble.columns(), &checked(name, "name"));
    return ASSUR_OK;
  });
}

std::int32_t assur_ensemble_run(assur_ensemble* ensemble, const double* times, std::size_t count,
                                const std::size_t* columns, std::size_t column_count, double* values,
                                std::size_t member_stride, std::size_t row_stride, std::size_t* rows,
                                assur_status* status) {
  return call([&] {
    Ensemble& of = checked(ensemble, "ensemble").ensemble;
    const std::vector<std::string> names = names_of(of.columns(), columns, column_count);
    const std::vector<double> at = c::times_of(times, count, of.time());
    const std::size_t width = names.size(), members = of.members();
    check_strides(members, at.size(), width, member_stride, row_stride);
    (void)checked(values, "values");
    std::vector<std::size_t> reached(members, 0);
    const auto row_of = [&](std::size_t i, std::size_t k) { return values + i * member_stride + k * row_stride; };
    const RowSink store = [&](const MemberRows& block) {
      for (std::size_t k = 0; k < block.times.size(); ++k) {
        std::copy_n(block.values.data() + k * width, width, row_of(block.member, reached[block.member]++));
      }
    };
    of.stream({names, 1, kRowsInBlock}, store, at);
    for (std::size_t i = 0; i < members; ++i) {
      for (std::size_t k = reached[i]; k < at.size(); ++k) std::fill_n(row_of(i, k), width, kNan);
    }
    if (rows != nullptr) std::copy(reached.begin(), reached.end(), rows);
    return give(of.report().status, status);
  });
}

std::int32_t assur_ensemble_summarize(assur_ensemble* ensemble, const double* times, std::size_t count,
                                      const std::size_t* columns, std::size_t column_count, assur_summary* out,
                                      std::size_t member_stride, assur_status* status) {
  return call([&] {
    Ensemble& of = checked(ensemble, "ensemble").ensemble;
    const std::vector<std::string> names = names_of(of.columns(), columns, column_count);
    const std::vector<double> at = c::times_of(times, count, of.time());
    const std::size_t width = names.size();
    c::check_stride("member_stride", member_stride, of.members(), width);
    (void)checked(out, "out");
    const EnsembleSummary summary = of.summarize(names, at);
    for (std::size_t i = 0; i < summary.members(); ++i) {
      for (std::size_t k = 0; k < width; ++k) {
        const ColumnSummary& s = summary(i, k);
        out[i * member_stride + k] = {s.minimum, s.maximum, s.minimum_time, s.maximum_time, s.mean, s.last};
      }
    }
    return give(of.report().status, status);
  });
}

std::int32_t assur_ensemble_outcome(const assur_ensemble* ensemble, std::size_t member, assur_outcome* outcome) {
  return call([&] {
    const std::vector<Ensemble::Outcome>& all = checked(ensemble, "ensemble").ensemble.outcomes();
    if (member >= all.size()) {
      throw Error(Error::Kind::input, all.empty() ? "the ensemble has not run yet"
                                                  : "there is no member " + std::to_string(member) + "; there are " +
                                                        std::to_string(all.size()) + ", counted from 0");
    }
    const Ensemble::Outcome& of = all[member];
    assur_outcome out{};
    out.size = sizeof out;
    (void)give(of.status, &out.status);
    out.reached = of.reached;
    out.cannot = of.cannot.c_str();
    give(out, outcome, "outcome");
    return ASSUR_OK;
  });
}

std::int32_t assur_ensemble_bind(assur_ensemble* ensemble, const double* values, std::size_t members,
                                 std::size_t member_stride) {
  return call([&] {
    assur_ensemble& of = checked(ensemble, "ensemble");
    of.ensemble.bind(c::table_of(values, members, member_stride, of.values_of_member));
    return ASSUR_OK;
  });
}

}  // extern "C"
