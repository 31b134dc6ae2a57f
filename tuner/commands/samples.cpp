#include <iostream>

#include "commands/commands.hpp"
#include "output/format.hpp"
#include "output/json.hpp"
#include "output/page.hpp"
#include "samples/samples.hpp"

namespace assur::command {
namespace {

using output::Json;

Json samples_as_json() {
  Json list = Json::array();
  for (const samples::SampleMechanism& sample : samples::table()) {
    Json options = Json::array();
    for (const samples::Option& o : sample.options) {
      const bool is_word = o.kind == samples::Option::Kind::word;
      options.push_back(
          {{"name", o.name}, {"meaning", o.meaning}, {"default", is_word ? Json(o.words.front()) : Json(o.value)}});
    }
    list.push_back({{"name", sample.name},
                    {"summary", sample.summary},
                    {"counted", output::or_null(sample.counted)},
                    {"options", std::move(options)}});
  }
  Json files = Json::array();
  for (const samples::SceneFile& file : samples::scene_files())
    files.push_back({{"name", file.name}, {"summary", file.summary()}});
  return {{"samples", std::move(list)}, {"files", std::move(files)}};
}

void print_samples(output::Page& page) {
  using enum output::Table::Align;
  const auto list = [&page](const std::vector<std::vector<std::string>>& rows) {
    output::Table table({left, left});
    for (const auto& row : rows) table.row(row);
    page.table(table);
    page.gap();
  };
  std::vector<std::vector<std::string>> rows;
  for (const samples::SampleMechanism& sample : samples::table()) {
    std::string options;
    for (const samples::Option& o : sample.options) (options += options.empty() ? "; " : ", ") += o.name;
    const std::string counted = sample.counted.empty() ? "" : "[:" + std::string(sample.counted) + "]";
    rows.push_back({std::string(sample.name) + counted, std::string(sample.summary) + options});
  }
  page.title("samples, with their options");
  page.gap();
  list(rows);
  rows.clear();
  for (const samples::SceneFile& file : samples::scene_files())
    rows.push_back({std::string(file.name), file.summary()});
  page.title("samples that are files in scenes/; their options are the parameters of the file");
  page.gap();
  list(rows);
  page.fact("use", "assur run stewart:legs=8, assur inspect four_bar:64, assur run bennett --animate bennett.html");
}

}  // namespace

int samples(const Common& common) {
  if (common.json) {
    output::print(std::cout, samples_as_json());
  } else {
    output::Page page(std::cout);
    print_samples(page);
  }
  return kDone;
}

}  // namespace assur::command
