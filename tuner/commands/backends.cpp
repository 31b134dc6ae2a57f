#include "assur/backend.hpp"
#include "commands/print_result.hpp"
#include "executors/step_code.hpp"
#include "output/json.hpp"
#include "output/notes.hpp"
#include "output/page.hpp"

namespace assur::command {
namespace {

using output::Json;
using output::Table;

struct BackendState {
  const Backend& backend;
  std::string version, why_not, slowed;
};

Json to_json(const std::vector<BackendState>& rows) {
  Json list = Json::array();
  for (const BackendState& row : rows) {
    list.push_back({{"id", row.backend.id},
                    {"available", row.why_not.empty()},
                    {"why_not", output::or_null(row.why_not)},
                    {"version", output::or_null(row.version)},
                    {"slowed", output::or_null(row.slowed)},
                    {"licence", row.backend.licence},
                    {"steady", row.backend.steady}});
  }
  const auto code = step_code();
  return {{"backends", std::move(list)}, {"machine_code", code ? Json(code->vectors()) : Json(nullptr)}};
}

void print(output::Page& page, const std::vector<BackendState>& rows) {
  using enum Table::Align;
  Table table({left, left, left, left, left});
  table.row({"backend", "runs here", "version", "licence", "steady"});
  for (const BackendState& row : rows) {
    table.row({std::string(row.backend.id), row.why_not.empty() ? "yes" : "no", row.version,
               std::string(row.backend.licence), row.backend.steady ? "yes" : "no"});
  }
  page.table(table);
  page.gap();
  page.fact("steady", "allocates nothing after the first factorisation");
  const auto code = step_code();
  page.fact("machine code", code ? code->vectors() + ", for steps of small groups with the backend lanes"
                                 : "none: it needs x86-64 with AVX2, and a build with AsmJit");
  for (const BackendState& row : rows) {
    if (!row.why_not.empty()) page.fact(row.backend.id, row.why_not);
  }
  for (const std::string& reason : output::slowed(assur::backends())) page.fact("slowed", reason);
}

}  // namespace

int backends(const Common& common) {
  std::vector<BackendState> rows;
  for (const Backend& backend : assur::backends()) {
    rows.push_back(
        {backend, backend.version(), backend.why_not(Shape{}, ThreadBudget{}), backend.slowed ? backend.slowed() : ""});
  }
  print_result(common, rows);
  return kDone;
}

}  // namespace assur::command
