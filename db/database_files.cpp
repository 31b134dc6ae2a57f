#include "db/database_files.hpp"

#include <dlfcn.h>
#include <sys/vfs.h>

#include <algorithm>
#include <array>
#include <cstdlib>

namespace assur::db {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFile = "assur/tuning.db";

std::optional<fs::path> users_database() {
  const char* const data = std::getenv("XDG_DATA_HOME");
  // the XDG specification ignores relative paths
  if (data && fs::path(data).is_absolute()) return fs::path(data) / kFile;
  const char* const home = std::getenv("HOME");
  if (home && fs::path(home).is_absolute()) return fs::path(home) / ".local/share" / kFile;
  return std::nullopt;
}

// The library or program that contains this code.
fs::path own_binary() {
  Dl_info info{};
  std::error_code error;
  if (dladdr(reinterpret_cast<const void*>(&own_database), &info) != 0 && info.dli_fname) {
    const fs::path file = fs::canonical(info.dli_fname, error);
    if (!error) return file;
  }
  return fs::canonical("/proc/self/exe", error);  // the program, for which dladdr may give only a name
}

// "/opt/assur" for "/opt/assur/lib/x86" and "lib/x86"; empty if the folder does not end with `end`.
fs::path prefix(fs::path folder, const fs::path& end) {
  for (auto part = end.end(); part != end.begin();) {
    if (folder.filename() != *--part) return {};
    folder = folder.parent_path();
  }
  return folder;
}

// An installed tree may have been moved: searches first relative to this binary, then at the place of installation.
std::optional<fs::path> installed_database() {
  std::error_code error;
  const fs::path folder = own_binary().parent_path();
  for (const char* part : {ASSUR_LIBDIR, ASSUR_BINDIR}) {
    const fs::path root = prefix(folder, part);
    const fs::path file = root / ASSUR_DATADIR / kFile;
    if (!root.empty() && fs::exists(file, error)) return file;
  }
  const fs::path file = fs::path(ASSUR_DATA_FOLDER) / kFile;
  return fs::exists(file, error) ? std::optional(file) : std::nullopt;
}

}  // namespace

std::optional<fs::path> own_database() {
  const char* const named = std::getenv("ASSUR_DB");
  if (!named) return users_database();
  return *named ? std::optional(fs::path(named)) : std::nullopt;
}

std::vector<DatabaseFile> database_files() {
  std::vector<DatabaseFile> files;
  const char* const named = std::getenv("ASSUR_DB");
  if (named && !*named) return files;
  using Role = DatabaseFile::Role;
  if (named) files.push_back({named, Role::named});
  if (const auto user = users_database()) files.push_back({*user, Role::user});
  if (const auto installed = installed_database()) files.push_back({*installed, Role::installation});
  return files;
}

bool is_network(std::uint64_t file_system) {
  constexpr std::array<std::uint64_t, 16> kNetworks = {
      0x6969,      // NFS
      0x517b,      // SMB
      0xfe534d42,  // SMB 2
      0xff534d42,  // CIFS
      0x5346414f,  // AFS of OpenAFS
      0x6b414653,  // AFS of Linux
      0x564c,      // NCP
      0x73757245,  // Coda
      0x00c36400,  // Ceph
      0x0bd00bd0,  // Lustre
      0x47504653,  // GPFS
      0x19830326,  // BeeGFS
      0x7461636f,  // OCFS2
      0x01161970,  // GFS2
      0x01021997,  // 9P
      0x65735546,  // FUSE: sshfs, GlusterFS, or a local file system, for which it costs little
  };
  return std::find(kNetworks.begin(), kNetworks.end(), file_system) != kNetworks.end();
}

bool is_on_network(const fs::path& file) {
  std::error_code error;
  fs::path folder = fs::absolute(file, error).parent_path();
  while (!folder.empty() && folder != folder.root_path() && !fs::exists(folder, error)) folder = folder.parent_path();
  struct statfs about {};
  if (statfs(folder.c_str(), &about) != 0) return false;
  return is_network(static_cast<std::uint32_t>(about.f_type));
}

}  // namespace assur::db
