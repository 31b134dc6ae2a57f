#include "report/paper/energy.hpp"

#include <fstream>
#include <optional>

#include "numbers.hpp"

namespace assur::report {
namespace {

namespace fs = std::filesystem;

template <class Value>
std::optional<Value> first_word(const fs::path& file) {
  std::ifstream in(file);
  Value value{};
  if (in >> value) return value;
  return std::nullopt;
}

// "intel-rapl:0", which includes its parts ("intel-rapl:0:1"). Processors of AMD have the same name.
bool is_zone(const std::string& name) {
  constexpr std::string_view kPrefix = "intel-rapl:";
  return name.starts_with(kPrefix) && name.find(':', kPrefix.size()) == std::string::npos;
}

}  // namespace

EnergyMeter::EnergyMeter(const fs::path& root) {
  const fs::path folder = root / "sys/class/powercap";
  std::error_code error;
  bool seen = false;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (!is_zone(entry.path().filename().string())) continue;
    const std::optional<std::string> name = first_word<std::string>(entry.path() / "name");
    if (!name || !name->starts_with("package")) continue;  // "psys" is the whole machine
    seen = true;
    const fs::path counter = entry.path() / "energy_uj";
    const std::optional<std::int64_t> range = first_word<std::int64_t>(entry.path() / "max_energy_range_uj");
    if (range && first_word<std::int64_t>(counter)) packages_.push_back({counter, *range});
  }
  if (packages_.empty()) {
    why_not_ = seen ? "the counters in " + folder.string() + " can only be read by the administrator"
                    : "this machine has no energy counters in " + folder.string();
  }
}

std::vector<std::int64_t> EnergyMeter::read() const {
  std::vector<std::int64_t> out;
  for (const Package& package : packages_) {
    const std::optional<std::int64_t> count = first_word<std::int64_t>(package.counter);
    if (!count) return {};
    out.push_back(*count);
  }
  return out;
}

double EnergyMeter::joules(const std::vector<std::int64_t>& from, const std::vector<std::int64_t>& to) const {
  if (packages_.empty() || from.size() != packages_.size() || to.size() != packages_.size()) {
    return kNan;
  }
  double microjoules = 0;
  for (std::size_t i = 0; i < packages_.size(); ++i) {
    const std::int64_t difference = to[i] - from[i];
    microjoules += static_cast<double>(difference < 0 ? difference + packages_[i].range : difference);
  }
  return microjoules * 1e-6;
}

}  // namespace assur::report
