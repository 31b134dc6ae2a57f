#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <tuple>

#include "commands/command.hpp"
#include "db/samples.hpp"
#include "db/store.hpp"

namespace assur {
namespace {

using test::bytes;
using test::host_with;
using test::make_database;
using test::sample_of;
using test::write_bytes;

Outcome ask(const std::string& file, std::vector<std::string> words) {
  words.insert(words.begin(), "db");
  words.insert(words.end(), {"--db", file});
  return run_command(words);
}

nlohmann::json rows(const std::string& file, std::vector<std::string> words) {
  words.push_back("--json");
  const Outcome outcome = ask(file, words);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  return outcome.json()["rows"];
}

TEST(Db, InfoShowsDatabasesAndSamplesInUse) {
  const Scratch scratch;
  const std::string file = scratch.file("tuning.db");
  make_database(file, db::this_host(), 12);
  make_database(file, host_with(4), 3);
  const Outcome outcome = ask(file, {"info", "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto info = outcome.json();
  EXPECT_EQ(info["machine"], db::this_host().fingerprint());
  EXPECT_EQ(info["believed"], 12);
  EXPECT_EQ(info["messages"].size(), 0u);
  ASSERT_EQ(info["rows"].size(), 1u);
  const auto& row = info["rows"][0];
  EXPECT_EQ(row["database"], file);
  EXPECT_EQ(row["role"], "named");
  EXPECT_TRUE(row["why_not"].is_null());
  EXPECT_EQ(row["samples"], 15);
  ASSERT_EQ(row["runs"].size(), 2u);
  EXPECT_EQ(row["runs"][0]["grade"], "good");
  EXPECT_EQ(row["runs"][1]["machine"], host_with(4).fingerprint());

  const Outcome page = ask(file, {"info"});
  EXPECT_EQ(page.status, 0);
  EXPECT_NE(page.out.find("12 samples"), std::string::npos) << page.out;
  EXPECT_NE(page.out.find(" (this)"), std::string::npos) << page.out;
}

TEST(Db, InfoExplainsUnreadableDatabases) {
  const Scratch scratch;
  const std::string file = scratch.file("notes.txt", "buy milk\n");
  const Outcome refused = ask(file, {"info", "--json"});
  EXPECT_EQ(refused.status, 3);
  const auto row = refused.json()["rows"].at(0);
  EXPECT_NE(row["why_not"].get<std::string>().find("not a tuning database"), std::string::npos);
  EXPECT_EQ(rows(scratch.file("absent.db"), {"info"}).at(0)["why_not"], "does not exist");
}

// Many bytes in the middle are damaged, and every command has to report this.
TEST(Db, EveryCommandReportsDamage) {
  const Scratch scratch;
  const std::string file = scratch.file("tuning.db");
  make_database(file, db::this_host(), 500);
  std::string damaged = bytes(file);
  const std::size_t middle = damaged.size() / 2;
  for (std::size_t i = 0; i < 3000; ++i) damaged[middle + i] = static_cast<char>(i * i * 7 + 3 * i);
  write_bytes(file, damaged);
  const std::string says = file + ": is damaged: database disk image is malformed; `assur tune --db " + file +
                           "` puts it aside and begins a new file";
  const auto in_one_line = [](const std::string& page) {
    std::istringstream words(page);
    std::string line;
    for (std::string word; words >> word;) line += (line.empty() ? "" : " ") + word;
    return line;
  };
  for (const char* command : {"plan", "run"}) {
    const Outcome outcome = run_command({command, "four_bar", "--db", file});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(in_one_line(outcome.out + outcome.err).find(says), std::string::npos)
        << command << outcome.out << outcome.err;
  }
  const Outcome info = ask(file, {"info", "--json"});
  EXPECT_EQ(info.status, 3);
  EXPECT_EQ(info.json()["believed"], 0);
  EXPECT_EQ(info.json()["rows"][0]["why_not"], says);
  const auto checked = rows(file, {"check"}).at(0);
  EXPECT_EQ(checked["samples"], 0);
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(file).parent_path()))
    ++files;
  EXPECT_EQ(files, 3u);  // the new file, the damaged one, and the lock
}

TEST(Db, PrintsSamplesBestCrossoversAndModelsAsRows) {
  const Scratch scratch;
  const std::string file = scratch.file("tuning.db");
  {
    db::Store store(file, db::Access::write);
    const std::int64_t run = store.begin_run(host_with(4), "quick");
    std::vector<Sample> samples = {sample_of(1, "klu"), sample_of(1, "eigen"), sample_of(5, "klu"),
                                   sample_of(5, "eigen")};
    samples[0].seconds = samples[3].seconds = 1e-7;  // klu is best at n = 4, eigen at n = 8
    samples[2].seconds = samples[1].seconds = 2e-7;
    for (Sample& sample : samples) sample.shape.rhs = 1;
    store.add(run, samples);
    store.put_model(host_with(4), "kernels", R"({"regret": 0.02})");
    store.put_model(host_with(2), "broken", "not JSON");
  }
  const auto samples = rows(file, {"samples"});
  ASSERT_EQ(samples.size(), 4u);
  EXPECT_EQ(samples[0]["kernel"], "factor");
  EXPECT_EQ(samples[0]["strategy"], "groups/klu");
  EXPECT_EQ(samples[0]["seconds"], 1e-7);
  EXPECT_TRUE(samples[0]["forward_error"].is_null());
  EXPECT_EQ(rows(file, {"samples", "--library", "eigen"}).size(), 2u);
  EXPECT_EQ(rows(file, {"samples", "--kernel", "solve"}).size(), 0u);
  EXPECT_EQ(rows(file, {"samples", "--machine", host_with(4).fingerprint().substr(0, 6)}).size(), 4u);
  EXPECT_EQ(rows(file, {"samples", "--strategy", "klu", "-n", "8"}).size(), 1u);
  const std::string csv = scratch.file("samples.csv");
  EXPECT_EQ(rows(file, {"samples", "--strategy", "eigen", "--csv", csv}).size(), 2u);
  const std::string written = content(csv);
  EXPECT_EQ(std::count(written.begin(), written.end(), '\n'), 3);  // a head and two samples

  const auto best = rows(file, {"best"});
  ASSERT_EQ(best.size(), 2u);
  EXPECT_EQ(best[0]["strategy"], "groups/klu");
  EXPECT_EQ(best[1]["strategy"], "groups/eigen");
  const auto crossovers = rows(file, {"crossovers"});
  ASSERT_EQ(crossovers.size(), 1u);
  EXPECT_EQ(crossovers[0]["n_before"], 4);
  EXPECT_EQ(crossovers[0]["n"], 8);

  const auto models = rows(file, {"models"});
  ASSERT_EQ(models.size(), 2u);
  EXPECT_EQ(models[0]["content"]["regret"], 0.02);
  EXPECT_EQ(models[1]["content"], "not JSON");

  for (const char* question : {"samples", "best", "crossovers", "models"}) {
    const Outcome page = ask(file, {question});
    EXPECT_EQ(page.status, 0);
    EXPECT_EQ(page.lines().at(0), file);
    EXPECT_GE(page.lines().size(), 3u) << page.out;
  }
  EXPECT_NE(ask(file, {"best"}).out.find("groups/klu          100 ns  groups/eigen  x 2.00"), std::string::npos)
      << ask(file, {"best"}).out;
}

TEST(Db, PlansForAnotherMachine) {
  const Scratch scratch;
  const std::string file = scratch.file("tuning.db"), other = host_with(4).fingerprint();
  make_database(file, host_with(4), 3);
  const auto plan = [&](const std::string& machine) {
    return run_command({"plan", "stewart", "--machine", machine, "--db", file, "--json"});
  };
  const Outcome known = plan(other.substr(0, 8));
  ASSERT_EQ(known.status, 0) << known.err;
  EXPECT_EQ(known.json()["samples"], 3);
  EXPECT_NE(known.json()["source"].get<std::string>().find("measured on Fast One"), std::string::npos);
  EXPECT_EQ(known.json()["budget"], db::Store(file, db::Access::read).runs().at(0).threads);
  EXPECT_TRUE(known.json()["machine_code"].is_null());
  const Outcome unknown = plan("zzz");
  EXPECT_EQ(unknown.status, 2);
  const std::string refusal = unknown.err + unknown.out;
  EXPECT_NE(refusal.find("has no machine zzz; it has "), std::string::npos) << refusal;
  EXPECT_NE(refusal.find(other), std::string::npos) << refusal;
}

TEST(Db, ExportsAndImports) {
  const Scratch scratch;
  const std::string ours = scratch.file("ours.db"), theirs = scratch.file("theirs.db"), file = scratch.file("file.db");
  make_database(ours, host_with(4), 8);
  EXPECT_EQ(rows(ours, {"export", file}).at(0)["samples"], 8);
  EXPECT_EQ(ask(ours, {"export", file}).status, 3);  // the file exists already
  const std::filesystem::path folder = scratch.file("no/such");
  EXPECT_EQ(ask(ours, {"export", folder / "file.db"}).err,
            "error: " + (folder / "file.db").string() + ": there is no folder " + folder.string() + "\n");
  EXPECT_FALSE(std::filesystem::exists(folder));
  auto imported = rows(theirs, {"import", file}).at(0);  // creates `theirs`
  EXPECT_EQ(imported["samples"], 8);
  EXPECT_EQ(imported["known"], 0);
  imported = rows(theirs, {"import", file}).at(0);
  EXPECT_EQ(imported["samples"], 0);
  EXPECT_EQ(imported["known"], 8);
  const std::string made = scratch.file("made.db");
  EXPECT_EQ(ask(made, {"import", scratch.file("absent.db")}).status, 3);
  EXPECT_FALSE(std::filesystem::exists(made));
}

TEST(Db, ForgetsOnlySelectedSamples) {
  const Scratch scratch;
  const std::string file = scratch.file("tuning.db");
  make_database(file, host_with(4), 8, "klu");
  make_database(file, host_with(2), 5, "eigen");
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"forget"}, {"forget", "--all", "--library", "klu"}}) {
    const Outcome outcome = ask(file, words);
    EXPECT_EQ(outcome.status, 2);
    EXPECT_NE(outcome.err.find("select the samples to forget"), std::string::npos) << outcome.err;
  }
  const auto forgotten = rows(file, {"forget", "--library", "klu"}).at(0);
  EXPECT_EQ(forgotten["samples"], 8);
  EXPECT_EQ(forgotten["runs"], 1);
  const std::string here = host_with(2).fingerprint();
  for (const auto& [option, text, wanted] : {std::tuple{"--machine", "nobody", "machine nobody; it has " + here},
                                             std::tuple{"--run", "1", std::string("tuning run 1; it has 2")}}) {
    for (const char* command : {"forget", "samples"}) {
      const Outcome outcome = ask(file, {command, option, text});
      EXPECT_EQ(outcome.status, 2) << command;
      EXPECT_EQ(outcome.err, "error: " + std::string(option) + ": " + file + " has no " + wanted + "\n");
    }
  }
  EXPECT_EQ(rows(file, {"forget", "--all"}).at(0)["samples"], 5);
  EXPECT_EQ(ask(scratch.file("absent.db"), {"forget", "--all"}).status, 3);
  EXPECT_FALSE(std::filesystem::exists(scratch.file("absent.db")));
}

TEST(Db, CheckPutsADamagedFileAside) {
  const Scratch scratch;
  const std::string file = scratch.file("tuning.db");
  make_database(file, host_with(4), 100);
  auto row = rows(file, {"check"}).at(0);
  EXPECT_EQ(row["samples"], 100);
  EXPECT_EQ(row["put_aside"].size(), 0u);
  std::string damaged = bytes(file);
  damaged.resize(damaged.size() - 5000);
  write_bytes(file, damaged);
  EXPECT_EQ(ask(file, {"samples"}).status, 3);
  row = rows(file, {"check"}).at(0);
  ASSERT_EQ(row["put_aside"].size(), 1u);
  EXPECT_NE(row["put_aside"][0].get<std::string>().find(".corrupt-"), std::string::npos);
  EXPECT_EQ(rows(file, {"check"}).at(0)["put_aside"].size(), 0u);
  EXPECT_EQ(rows(file, {"samples"}).size(), row["samples"]);
  EXPECT_NE(ask(file, {"check"}).out.find("undamaged"), std::string::npos);
}

TEST(Db, AFileThatIsNoDatabaseIsAnEnvironmentError) {
  const Scratch scratch;
  const std::string text = scratch.file("notes.txt", "buy milk\n");
  for (const char* question : {"samples", "best", "crossovers", "models", "check"}) {
    for (const std::string& file : {text, scratch.file("absent.db")}) {
      const Outcome outcome = ask(file, {question, "--json"});
      EXPECT_EQ(outcome.status, 3) << question;
      EXPECT_EQ(outcome.json()["error"]["kind"], "environment");
    }
  }
  EXPECT_FALSE(std::filesystem::exists(scratch.file("absent.db")));
  EXPECT_EQ(bytes(text), "buy milk\n");
}

}  // namespace
}  // namespace assur
