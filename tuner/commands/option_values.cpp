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
