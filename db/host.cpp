#include "db/host.hpp"

#include <unistd.h>

#include <array>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <locale>

#include "db/checksum.hpp"
#include "decimal.hpp"
#include "parallel/machine.hpp"
#include "parallel/thread_state.hpp"

namespace assur::db {
namespace {

// Parses "25" or "0x41"; -1 for anything else.
std::int32_t parse_number(std::string_view text) {
  const bool hex = text.starts_with("0x");
  if (hex) text.remove_prefix(2);
  std::int32_t number = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, hex ? 16 : 10);
  return error == std::errc() && end == text.data() + text.size() ? number : -1;
}

// Reads lines "key : value" of the first processor, in Linux's formats for x86 and ARM.
void read_processor(std::istream& cpuinfo, Host& host) {
  std::int32_t variant = -1, revision = -1;
  for (std::string line; std::getline(cpuinfo, line) && !line.empty();) {
    const auto colon = line.find(':');
    if (colon == std::string::npos) continue;
    const std::string key = line.substr(0, line.find_last_not_of(" \t", colon - 1) + 1);
    const std::string value = colon + 2 < line.size() ? line.substr(colon + 2) : "";
    if (key == "vendor_id" || key == "CPU implementer") host.vendor = value;
    if (key == "cpu family" || key == "CPU architecture") host.family = parse_number(value);
    if (key == "model" || key == "CPU part") host.model = parse_number(value);
    if (key == "stepping") host.stepping = parse_number(value);
    if (key == "CPU variant") variant = parse_number(value);
    if (key == "CPU revision") revision = parse_number(value);
    if (key == "microcode") host.microcode = value;
  }
  if (variant >= 0 && revision >= 0) host.stepping = variant * 16 + revision;
}

// The first line is "MemTotal:  16384 kB".
std::int64_t memory(const std::filesystem::path& root) {
  std::ifstream file(root / "proc/meminfo");
  file.imbue(std::locale::classic());
  std::string key;
  std::int64_t kibibytes = 0;
  return file >> key >> kibibytes && key == "MemTotal:" ? kibibytes * 1024 : 0;
}

// Unidentified processors may differ, so only the same computer has the same fingerprint.
std::string name_of_computer() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

bool same_processor(const Host& a, const Host& b) {
  return a.stepping == b.stepping && a.machine.model == b.machine.model &&
         a.machine.instructions == b.machine.instructions;
}

}  // namespace

std::string Host::fingerprint() const {
  Checksum sum;
  sum << vendor << std::int64_t{family} << std::int64_t{model} << std::int64_t{stepping} << machine.model
      << machine.instructions << static_cast<std::int64_t>(machine.cores.size()) << std::int64_t{machine.processors}
      << machine.quota << std::int64_t{machine.numa_nodes};
  for (const Cache& cache : machine.caches)
    sum << std::int64_t{cache.level} << cache.bytes << std::int64_t{cache.cores};
  return hexadecimal(sum.value());
}

Host read_host(const std::filesystem::path& root, const std::vector<int>& allowed, const std::string& omp_num_threads) {
  Host host;
  host.machine = read_machine(root, allowed, omp_num_threads);
  std::ifstream cpuinfo(root / "proc/cpuinfo");
  read_processor(cpuinfo, host);
  if (host.vendor.empty() && host.machine.model.empty()) host.machine.model = "processor of " + name_of_computer();
  host.memory = memory(root);
  return host;
}

Host this_host() {
  const char* const omp_num_threads = std::getenv("OMP_NUM_THREADS");
  return read_host("/", allowed_processors(), omp_num_threads ? omp_num_threads : "");
}

Likeness likeness(const Host& a, const Host& b) {
  if (a.fingerprint() == b.fingerprint()) return Likeness::same;
  const bool known = !a.vendor.empty() && a.family >= 0 && a.model >= 0;
  if (!known || a.vendor != b.vendor || a.family != b.family || a.model != b.model) return Likeness::none;
  return same_processor(a, b) ? Likeness::processor : Likeness::microarchitecture;
}

std::string to_string(const Host& host) {
  std::string text = host.machine.model.empty() ? "unknown processor" : host.machine.model;
  if (!host.vendor.empty()) {
    text += " (" + host.vendor + " " + std::to_string(host.family) + "/" + std::to_string(host.model) + "/" +
            std::to_string(host.stepping) + ")";
  }
  const std::size_t cores = host.machine.cores.size();
  text += ", " + host.machine.instructions + ", " + std::to_string(cores) + (cores == 1 ? " core" : " cores");
  if (host.machine.quota > 0) text += ", quota " + general(host.machine.quota, 6);
  return text;
}

}  // namespace assur::db
