#include "output/answer.hpp"

#include <algorithm>
#include <set>

#include "output/format.hpp"

namespace assur::output {
namespace {

Json to_json(const db::Value& value) {
  struct Visitor {
    Json operator()(std::monostate) const { return nullptr; }
    Json operator()(std::int64_t number) const { return number; }
    Json operator()(double number) const { return number; }
    Json operator()(const std::string& text) const { return text; }
  };
  return std::visit(Visitor{}, value);
}

std::string of_double(const std::string& column, double value) {
  if (column.ends_with("error")) return error_figure(value);
  if (column == "seconds" || column == "spread") return duration(value);
  if (column == "runner_up_takes") return "x " + fixed(value);
  return number(value);
}

std::string cell(const std::string& column, const db::Value& value) {
  if (const auto* const text = std::get_if<std::string>(&value)) {
    return column == "machine" ? text->substr(0, 8) : *text;
  }
  if (const auto* const count = std::get_if<std::int64_t>(&value)) {
    return column == "dense" ? (*count ? "dense" : "sparse") : grouped(*count);
  }
  const auto* const real = std::get_if<double>(&value);
  return real ? of_double(column, *real) : "";
}

std::size_t place(const db::Answer& answer, const std::string& column) {
  return static_cast<std::size_t>(std::find(answer.columns.begin(), answer.columns.end(), column) -
                                  answer.columns.begin());
}

bool one_machine(const db::Answer& answer) {
  const std::size_t c = place(answer, "machine");
  std::set<db::Value> machines;
  for (const auto& row : answer.rows) {
    if (c < row.size()) machines.insert(row[c]);
  }
  return machines.size() < 2;
}

bool is_text(const db::Answer& answer, std::size_t c) {
  return std::any_of(answer.rows.begin(), answer.rows.end(),
                     [&](const auto& row) { return std::holds_alternative<std::string>(row[c]); });
}

}  // namespace

Json to_json(const db::Answer& answer) {
  Json rows = Json::array();
  for (const auto& row : answer.rows) {
    Json object;
    for (std::size_t c = 0; c < row.size(); ++c) {
      const std::string& column = answer.columns[c];
      const auto* const text = std::get_if<std::string>(&row[c]);
      Json content = column == "content" && text ? Json::parse(*text, nullptr, false) : to_json(row[c]);
      object[column] = content.is_discarded() ? Json(*text) : std::move(content);
    }
    rows.push_back(std::move(object));
  }
  return rows;
}

void print(Page& page, const db::Answer& answer, const std::vector<std::pair<std::string, std::string>>& columns) {
  std::vector<std::size_t> places;
  std::vector<Table::Align> align;
  std::vector<std::string> titles;
  for (const auto& [column, title] : columns) {
    if (column == "machine" && one_machine(answer)) continue;
    places.push_back(place(answer, column));
    align.push_back(is_text(answer, places.back()) || column == "dense" ? Table::Align::left : Table::Align::right);
    titles.push_back(title);
  }
  Table table(align);
  table.row(titles);
  for (const auto& row : answer.rows) {
    std::vector<std::string> cells;
    for (const std::size_t c : places) cells.push_back(cell(answer.columns[c], row[c]));
    table.row(std::move(cells));
  }
  page.table(table);
}

}  // namespace assur::output
