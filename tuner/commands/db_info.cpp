// assur db info
#include <algorithm>
#include <iostream>

#include "commands/db_parts.hpp"
#include "db/machine_model.hpp"
#include "db/unusable.hpp"
#include "output/format.hpp"
#include "output/json.hpp"
#include "output/page.hpp"

namespace assur::command {
namespace {

using output::Json;
using output::Page;
using output::Table;

struct DatabaseState {
  db::DatabaseFile place;
  std::string why_not;   // why it cannot be read
  bool refused = false;  // it exists, but cannot be read
  std::vector<db::Run> runs;
  db::Counts counts;
};

std::string role(db::DatabaseFile::Role role) {
  switch (role) {
    case db::DatabaseFile::Role::named:
      return "named";
    case db::DatabaseFile::Role::user:
      return "user";
    case db::DatabaseFile::Role::installation:
      return "installation";
  }
  return "";
}

DatabaseState look(const db::DatabaseFile& place, const std::string& here) {
  DatabaseState row{place, {}, false, {}, {}};
  try {
    const db::Store store(place.file, db::Access::read);
    row.runs = store.runs();
    row.counts = store.counts(here);
  } catch (const db::Unusable& unusable) {
    row.refused = unusable.trouble() != db::Trouble::absent;
    row.why_not = row.refused ? unusable.what() : "does not exist";
  }
  return row;
}

Json to_json(const db::Run& run) {
  return {{"run", run.id},
          {"machine", run.machine},
          {"profile", run.profile},
          {"started", run.started},
          {"finished", run.finished},
          {"grade", output::or_null(run.finished, run.grade)},
          {"seconds", output::or_null(run.finished, run.seconds)},
          {"coverage", output::or_null(run.finished, run.coverage)},
          {"threads", run.threads},
          {"load", run.load},
          {"assur", run.assur},
          {"samples", run.samples},
          {"note", run.note}};
}

Json to_json(const std::vector<DatabaseState>& rows) {
  Json list = Json::array();
  for (const DatabaseState& row : rows) {
    Json runs = Json::array();
    for (const db::Run& run : row.runs) runs.push_back(to_json(run));
    list.push_back({{"database", row.place.file.string()},
                    {"role", role(row.place.role)},
                    {"why_not", output::or_null(row.why_not)},
                    {"samples", row.counts.samples},
                    {"stale", row.counts.stale},
                    {"runs", std::move(runs)}});
  }
  return list;
}

void print(Page& page, const DatabaseState& row, const std::string& here) {
  page.title(row.place.file.string());
  page.fact("role", role(row.place.role));
  if (!row.why_not.empty()) {
    page.fact("not read", row.why_not);
    return;
  }
  page.fact("samples",
            output::grouped(row.counts.samples) +
                (row.counts.stale > 0 ? ", " + output::grouped(row.counts.stale) + " of other library versions" : ""));
  if (row.runs.empty()) return;
  using enum Table::Align;
  Table table({right, left, left, left, left, right, right});
  table.row({"run", "machine", "profile", "started", "grade", "took", "samples"});
  for (const db::Run& run : row.runs) {
    table.row({std::to_string(run.id), run.machine.substr(0, 8) + (run.machine == here ? " (this)" : ""), run.profile,
               run.started, run.finished ? run.grade : "unfinished", run.finished ? output::duration(run.seconds) : "",
               output::grouped(run.samples)});
  }
  page.table(table);
}

}  // namespace

int db_info(const Common& common) {
  const std::vector<db::DatabaseFile> files = databases_of(common);
  const db::Host host = db::this_host();
  std::vector<DatabaseState> rows;
  for (const db::DatabaseFile& file : files) rows.push_back(look(file, host.fingerprint()));
  const bool refused = std::any_of(rows.begin(), rows.end(), [](const DatabaseState& row) { return row.refused; });
  const MachineModel model = db::read_machine_model(files, host, db::library_at_hand);
  if (common.json) {
    output::print(std::cout, {{"machine", host.fingerprint()},
                              {"rows", to_json(rows)},
                              {"believed", model.model->samples()},
                              {"source", model.model->source()},
                              {"messages", model.messages}});
    return refused ? kEnvironment : kDone;
  }
  Page page(std::cout);
  page.title("This machine: " + to_string(host));
  page.fact("fingerprint", host.fingerprint());
  page.fact("used", output::counted(model.model->samples(), "sample"));
  if (!model.model->source().empty()) page.fact("", model.model->source());
  page.list("note", model.messages);
  for (const DatabaseState& row : rows) {
    page.gap();
    print(page, row, host.fingerprint());
  }
  return refused ? kEnvironment : kDone;
}

}  // namespace assur::command
