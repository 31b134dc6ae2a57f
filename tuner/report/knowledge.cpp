#include "report/knowledge.hpp"

#include <algorithm>
#include <cmath>

#include "assur/backend.hpp"
#include "db/libraries.hpp"
#include "db/unusable.hpp"
#include "output/format.hpp"
#include "output/notes.hpp"

namespace assur::report {
namespace {

bool of_everything(const db::Run& run) {
  return run.profile == "quick" || run.profile == "standard" || run.profile == "patient";
}

std::optional<TuningRecord> record_in(const db::DatabaseFile& place, const std::string& fingerprint) {
  try {
    const db::Store store(place.file, db::Access::read);
    const std::vector<db::Run> runs = store.runs();
    const auto last = std::find_if(runs.rbegin(), runs.rend(), [&](const db::Run& run) {
      return run.finished && run.machine == fingerprint && of_everything(run);
    });
    if (last == runs.rend()) return std::nullopt;
    TuningRecord record{place.file.string(), *last, {}, {}};
    db::Filter filter;
    filter.run = last->id;
    record.samples = store.samples(filter);
    filter = {};
    filter.machine = fingerprint;
    record.crossovers = store.crossovers(filter);
    return record;
  } catch (const db::Unusable& unusable) {
    // The model's messages report why other databases cannot be read.
    if (place.role == db::DatabaseFile::Role::named && unusable.trouble() != db::Trouble::absent) throw;
    return std::nullopt;
  }
}

std::string size_text(std::int64_t bytes) {
  constexpr double kKiB = 1024, kMiB = 1024 * 1024, kGiB = 1024 * kMiB;
  const auto size = static_cast<double>(bytes);
  if (size >= 4 * kGiB) return output::number(std::round(size / kGiB)) + " GiB";
  return size >= kMiB ? output::number(std::round(10 * size / kMiB) / 10) + " MiB"
                      : output::number(size / kKiB) + " KiB";
}

std::string caches_text(const Machine& machine) {
  std::string text;
  for (const Cache& cache : machine.caches) {
    text += (text.empty() ? "L" : ", L") + std::to_string(cache.level) + " " + size_text(cache.bytes);
    if (cache.cores > 1) text += " for " + output::counted(cache.cores, "core");
  }
  return text.empty() ? "not known" : text;
}

std::string tuning_text(const Knowledge& k) {
  if (!k.tuning) return k.known.model->samples() == 0 ? "none: no samples of this machine" : k.known.model->source();
  const db::Run& run = k.tuning->run;
  return k.tuning->file + ": run " + std::to_string(run.id) + " (" + run.profile + ") of " + run.started + ", grade " +
         run.grade + ", " + output::counted(run.samples, "sample") + " in " + output::duration(run.seconds) +
         (run.note.empty() ? "" : "; " + run.note);
}

}  // namespace

Knowledge knowledge(MachineModel known, std::span<const db::DatabaseFile> databases) {
  Knowledge out{this_machine(), db::this_host(), std::move(known), std::nullopt};
  for (const db::DatabaseFile& place : databases) {
    out.tuning = record_in(place, out.host.fingerprint());
    if (out.tuning) break;
  }
  return out;
}

Facts facts(const Knowledge& k, int threads, const std::string& date) {
  const Machine& m = k.machine;
  const auto count = [](auto n) { return static_cast<std::int64_t>(n); };
  const db::Library build = db::library_at_hand("assur");
  Facts out = {
      {"processor", (m.model.empty() ? "not known" : m.model) + ", " + m.instructions},
      {"cores", output::counted(count(m.cores.size()), "core") + ", " + output::counted(m.processors, "processor") +
                    ", " + output::counted(m.numa_nodes, "memory node") + "; quota: " +
                    (m.quota > 0 ? output::counted(count(std::ceil(m.quota)), "processor") : std::string("none")) +
                    "; threads used: at most " + std::to_string(threads)},
      {"caches", caches_text(m) + "; memory " + size_text(k.host.memory)},
      {"fingerprint", k.host.fingerprint()},
      {"assur", std::string(db::assur_version()) + ", " + build.build},
  };
  std::string libraries;
  for (const Backend& backend : backends()) {
    const std::string version = backend.version();
    libraries +=
        (libraries.empty() ? "" : "; ") + std::string(backend.id) + ": " + (version.empty() ? "absent" : version);
  }
  out.emplace_back("solvers", libraries);
  for (const std::string& reason : output::slowed(backends())) out.emplace_back("slowed", reason);
  out.emplace_back("tuning", tuning_text(k));
  out.emplace_back("date", date);
  return out;
}

std::string how_to_tune(const Knowledge& k) {
  if (k.tuning) return "";
  const std::string first =
      k.known.model->samples() == 0
          ? "There are no samples of this machine yet: auto uses times of a typical processor by counts of "
            "operations (the prior)."
          : "auto uses samples of other machines or of single scenes: " + k.known.model->source() + ".";
  return first + " Run `assur tune`, which measures this machine in a minute, and repeat the report.";
}

}  // namespace assur::report
