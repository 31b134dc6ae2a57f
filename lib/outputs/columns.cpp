#include "outputs/columns.hpp"

#include <algorithm>
#include <cmath>

#include "assur/status.hpp"
#include "scene/names.hpp"

namespace assur {

std::size_t column_index(const std::vector<std::string>& columns, std::string_view column) {
  const auto found = std::find(columns.begin(), columns.end(), column);
  if (found == columns.end()) {
    throw Error(Error::Kind::input,
                "no column " + in_quotes(column) + known_instead(column, {columns.begin(), columns.end()}));
  }
  return static_cast<std::size_t>(found - columns.begin());
}

Missing missing_from(std::span<const double> row) {
  Missing out;
  for (std::size_t c = 0; c < row.size(); ++c) {
    if (!std::isnan(row[c])) continue;
    if (out.count < out.first.size()) out.first[out.count] = static_cast<std::int32_t>(c);
    ++out.count;
  }
  return out;
}

std::string without_derivatives(const std::vector<std::string>& columns, const Missing& missing) {
  if (missing.count == 0) return "";
  std::string names;
  for (std::size_t i = 0; i < std::min(missing.count, missing.first.size()); ++i) {
    names += (i == 0 ? "" : ", ") + columns[static_cast<std::size_t>(missing.first[i])];
  }
  if (missing.count > missing.first.size()) names += ", ...";
  return "there is no " + names + ": an angle without a sign has no derivatives at 0 and pi, a distance none at 0";
}

}  // namespace assur
