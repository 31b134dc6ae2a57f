#include "parallel/cgroup.hpp"

#include <algorithm>
#include <fstream>
#include <locale>
#include <sstream>
#include <string>
#include <vector>

namespace assur {
namespace {

using std::filesystem::path;

// A mounted hierarchy of groups: version 2, or version 1 with the given controller.
struct Hierarchy {
  int version;
  std::string top;  // the group that the mount shows as its root
  path mount_point;
};

bool has_item(const std::string& list, const std::string& item) {
  return ("," + list + ",").find("," + item + ",") != std::string::npos;
}

// Replaces the octal escapes of mountinfo, such as \040 for a space.
std::string unescaped(const std::string& text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::string octal = text[i] == '\\' ? text.substr(i + 1, 3) : "";
    if (octal.size() == 3 && octal.find_first_not_of("01234567") == std::string::npos) {
      plain += static_cast<char>(std::stoi(octal, nullptr, 8));
      i += 3;
    } else {
      plain += text[i];
    }
  }
  return plain;
}

// Lines of mountinfo: id, parent, device, top, mount point, options, optional fields, "-", type, source, options.
std::vector<Hierarchy> hierarchies(const path& root, const std::string& controller) {
  std::vector<Hierarchy> found;
  std::ifstream file(root / "proc/self/mountinfo");
  for (std::string line; std::getline(file, line);) {
    const auto dash = line.find(" - cgroup");
    if (dash == std::string::npos) continue;  // most lines are of other file systems
    std::istringstream left(line.substr(0, dash)), right(line.substr(dash + 3));
    std::string skipped, top, mount_point, type, source, options;
    left >> skipped >> skipped >> skipped >> top >> mount_point;
    right >> type >> source >> options;
    const int version = type == "cgroup2" ? 2 : type == "cgroup" && has_item(options, controller) ? 1 : 0;
    if (version != 0) found.push_back({version, unescaped(top), unescaped(mount_point)});
  }
  return found;
}

// The group of this process in a hierarchy. Lines are id:controllers:group, and "0::/..." for version 2.
std::string group_of_this_process(const path& root, int version, const std::string& controller) {
  std::ifstream file(root / "proc/self/cgroup");
  for (std::string line; std::getline(file, line);) {
    const auto first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    if (version == 2 ? line.rfind("0::", 0) == 0 : has_item(controllers, controller)) return line.substr(second + 1);
  }
  return "/";
}

// Path below the mount point. A container may not show the group; the mount's root is then used.
path below_mount_point(const std::string& group, const std::string& top) {
  const std::string prefix = top == "/" ? "" : top;
  const bool shown = group == prefix || group.rfind(prefix + "/", 0) == 0;
  if (!shown || group.find("/..") != std::string::npos) return {};
  return path(group.substr(prefix.size())).relative_path();
}

double quotient(double quota, double period) { return quota > 0 && period > 0 ? quota / period : 0; }

double read_number(const path& name) {
  std::ifstream file(name);
  file.imbue(std::locale::classic());
  double number = 0;
  file >> number;
  return number;
}

// CPU quota of one group in cores; 0 if there is none ("max", -1), or no such file.
double quota_of(const path& group, int version) {
  if (version == 1) return quotient(read_number(group / "cpu.cfs_quota_us"), read_number(group / "cpu.cfs_period_us"));
  std::ifstream file(group / "cpu.max");
  file.imbue(std::locale::classic());
  double quota = 0, period = 0;
  return file >> quota >> period ? quotient(quota, period) : 0;
}

// The smallest positive value of the groups from that of this process to the top; 0: none.
template <class Say>
double least_on_the_way(const path& root, const std::string& controller, const Say& say) {
  double least = 0;
  for (const Hierarchy& hierarchy : hierarchies(root, controller)) {
    path group = below_mount_point(group_of_this_process(root, hierarchy.version, controller), hierarchy.top);
    for (;; group = group.parent_path()) {
      const double said = say(root / hierarchy.mount_point.relative_path() / group, hierarchy.version);
      if (said > 0) least = least > 0 ? std::min(least, said) : said;
      if (group.empty()) break;
    }
  }
  return least;
}

// The value behind `name` in a file of lines "name value"; 0 if there is none.
double read_named(const path& file_name, const std::string& name) {
  std::ifstream file(file_name);
  file.imbue(std::locale::classic());
  std::string found;
  for (double value = 0; file >> found >> value;) {
    if (found == name) return value;
  }
  return 0;
}

// Bytes that one group may still take, at least 1; 0 if it has no limit. Inactive pages of files can be reclaimed, so
// they are not counted as used.
double memory_of(const path& group, int version) {
  const double most = read_number(group / (version == 2 ? "memory.max" : "memory.limit_in_bytes"));
  if (!(most > 0)) return 0;
  const double used = read_number(group / (version == 2 ? "memory.current" : "memory.usage_in_bytes"));
  const double files = read_named(group / "memory.stat", version == 2 ? "inactive_file" : "total_inactive_file");
  return std::max(1.0, most - std::max(0.0, used - files));
}

}  // namespace

double cpu_quota(const path& root) { return least_on_the_way(root, "cpu", quota_of); }

double cgroup_memory(const path& root) { return least_on_the_way(root, "memory", memory_of); }

}  // namespace assur
