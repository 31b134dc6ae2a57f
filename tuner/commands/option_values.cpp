#include "commands/option_values.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <sstream>

namespace assur::options {

void take_parameter(Parameters& set, const std::string& text) {
  const std::size_t equals = text.find('=');
  double value = 0;
  if (equals == 0 || equals == std::string::npos || !CLI::detail::lexical_cast(text.substr(equals + 1), value) ||
      !std::isfinite(value)) {
    throw CLI::ValidationError("--set", "expects name=number, not \"" + text + "\"");
  }
  if (!set.emplace(text.substr(0, equals), value).second) {
    throw CLI::ValidationError("--set", "is given twice for \"" + text.substr(0, equals) + "\"");
  }
}

void take_drive(std::vector<std::pair<std::string, std::string>>& drive, const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == 0 || equals == std::string::npos) {
    throw CLI::ValidationError("--drive", "expects joint=LAW, not \"" + text + "\"");
  }
  drive.emplace_back(text.substr(0, equals), text.substr(equals + 1));
}

void take_mode(std::vector<std::pair<std::string, std::size_t>>& modes, const std::string& text) {
  const std::size_t equals = text.rfind('=');
  const std::string number = equals == std::string::npos ? text : text.substr(equals + 1);
  std::size_t mode = 0;
  if (equals == 0 || number.empty() || number.find_first_not_of("0123456789") != std::string::npos ||
      !CLI::detail::lexical_cast(number, mode)) {
    throw CLI::ValidationError("--start-mode", "expects a number from 0, or GROUP=number, not \"" + text + "\"");
  }
  modes.emplace_back(equals == std::string::npos ? "" : text.substr(0, equals), mode);
}

void take_guess(std::vector<std::pair<std::string, std::vector<double>>>& guesses, const std::string& text) {
  const auto refuse = [&] {
    throw CLI::ValidationError("--guess", "expects a point with its place, as C=1.2,0.3, not \"" + text + "\"");
  };
  const std::size_t equals = text.find('=');
  if (equals == 0 || equals == std::string::npos) refuse();
  std::vector<double> at;
  std::istringstream list(text.substr(equals + 1) + ",");
  for (std::string item; std::getline(list, item, ',');) {
    double value = 0;
    if (!CLI::detail::lexical_cast(item, value) || !std::isfinite(value)) refuse();
    at.push_back(value);
  }
  if (at.size() != 2 && at.size() != 3) refuse();
  guesses.emplace_back(text.substr(0, equals), std::move(at));
}

void take_accuracies(std::vector<double>& accuracies, const std::string& text) {
  accuracies.clear();
  std::istringstream list(text);
  for (std::string item; std::getline(list, item, ',');) {
    double value = 0;
    if (!CLI::detail::lexical_cast(item, value) || !std::isfinite(value) || !(value > 0)) {
      throw CLI::ValidationError("--accuracy", "expects numbers > 0 such as 1e-4,1e-8, not \"" + text + "\"");
    }
    accuracies.push_back(value);
  }
  if (accuracies.empty()) throw CLI::ValidationError("--accuracy", "expects numbers > 0 such as 1e-4,1e-8");
  std::sort(accuracies.begin(), accuracies.end(), std::greater<>());
  accuracies.erase(std::unique(accuracies.begin(), accuracies.end()), accuracies.end());
}

void take_ranges(std::vector<sweep::Range>& ranges, const std::string& text) {
  std::istringstream list(text);
  for (std::string item; std::getline(list, item, ',');) {
    const std::size_t equals = item.find('='), colon = item.find(':', equals);
    sweep::Range range;
    const bool is_range = equals != 0 && equals != std::string::npos && colon != std::string::npos &&
                          CLI::detail::lexical_cast(item.substr(equals + 1, colon - equals - 1), range.low) &&
                          CLI::detail::lexical_cast(item.substr(colon + 1), range.high);
    if (!is_range) throw CLI::ValidationError("--vary", "expects a=0.2:0.8, not \"" + item + "\"");
    range.name = item.substr(0, equals);
    ranges.push_back(range);
  }
}

std::pair<std::int64_t, std::int64_t> sample_range(const std::string& text) {
  const std::size_t colon = text.find(':');
  std::pair<std::int64_t, std::int64_t> range;
  if (colon == std::string::npos || !CLI::detail::lexical_cast(text.substr(0, colon), range.first) ||
      !CLI::detail::lexical_cast(text.substr(colon + 1), range.second)) {
    throw CLI::ValidationError("--range",
                               "expects I:J, the first sample and the one after the last, not \"" + text + "\"");
  }
  return range;
}

void take_names(std::vector<std::string>& names, const std::string& text, const std::string& option) {
  for (std::size_t from = 0, comma = 0; comma != std::string::npos; from = comma + 1) {
    comma = text.find(',', from);
    names.push_back(text.substr(from, comma - from));
    if (names.back().empty()) throw CLI::ValidationError(option, "expects names such as A,B, not \"" + text + "\"");
  }
}

CLI::Validator number(double above, const std::string& what, double most) {
  return CLI::Validator(
      [above, what, most](std::string& text) {
        double value = 0;
        const bool fits =
            CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value > above && value <= most;
        return fits ? std::string() : "expects a number" + what + ", not \"" + text + "\"";
      },
      "");
}
CLI::Validator accuracy() {
  return CLI::Validator(
      [](std::string& text) {
        double value = 0;
        const bool fits = CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value >= 0;
        return fits ? std::string() : "expects a number > 0, or 0, not \"" + text + "\"";
      },
      "");
}
CLI::Validator whole_number(int least) {
  return CLI::Validator(
      [least](std::string& text) {
        int value = 0;
        const bool fits = CLI::detail::lexical_cast(text, value) && value >= least;
        if (fits) return std::string();
        return "expects a whole number from " + std::to_string(least) + " to " +
               std::to_string(std::numeric_limits<int>::max()) + ", not \"" + text + "\"";
      },
      "");
}

CLI::Validator one_of(const std::vector<std::string>& names) {
  return CLI::Validator(
      [names](std::string& text) {
        if (std::find(names.begin(), names.end(), text) != names.end()) return std::string();
        std::string list = names.front();
        for (std::size_t i = 1; i < names.size(); ++i) list += (i + 1 < names.size() ? ", " : " or ") + names[i];
        return "expects " + list + ", not \"" + text + "\"";
      },
      "");
}

}  // namespace assur::options
