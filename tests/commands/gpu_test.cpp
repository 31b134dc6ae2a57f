// The command with backends on a GPU: without one, and with libraries that replace those of NVIDIA
// (tests/backends/cuda_stand_in.cpp).
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <set>

#include "assur/backend.hpp"
#include "commands/command.hpp"
#include "db/store.hpp"

namespace assur {
namespace {

// Commands find the stand-in, with this fault.
Setting stand_in(const char* mode) {
  Setting setting;
  setting.before = [mode] {
    setenv("LD_LIBRARY_PATH", ASSUR_GPU_STAND_IN, 1);
    setenv("ASSUR_STAND_IN", mode, 1);
  };
  return setting;
}

// The fact about a backend below the table of `assur backends`, without line breaks.
std::string fact(const std::string& backend, const Outcome& outcome) {
  std::string text;
  bool inside = false;
  for (const std::string& line : outcome.lines()) {
    const bool more = line.rfind("                  ", 0) == 0;
    inside = more ? inside : line.rfind("  " + backend + "  ", 0) == 0 && line.find("  no  ") == std::string::npos;
    if (inside) text += (text.empty() ? "" : " ") + line.substr(18);
  }
  return text;
}

TEST(Gpu, WithoutADriverTheCommandSaysWhatIsMissing) {
  if (dlopen("libcuda.so.1", RTLD_LAZY | RTLD_LOCAL) != nullptr) GTEST_SKIP() << "this computer has an NVIDIA driver";
  const std::string missing =
      "no NVIDIA driver (libcuda.so.1) was found: cusolver needs an NVIDIA GPU, its driver, and the libraries of CUDA "
      "11, 12 or 13";
  EXPECT_EQ(fact("cusolver", run_command({"backends"})), missing);
  const Outcome run = run_command({"run", "stewart", "--strategy", "groups/cusolver"});
  EXPECT_EQ(run.status, 3);
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(run.err, "error: backend cusolver cannot run here: " + missing + "\n");
}

TEST(Gpu, WithoutADeviceTheCommandSaysSo) {
  const std::string missing =
      "the NVIDIA driver offers no device (no CUDA-capable device is detected); nvidia-smi lists devices, and "
      "CUDA_VISIBLE_DEVICES may hide them";
  EXPECT_EQ(fact("cusolver", run_command({"backends"}, stand_in("no_device"))), missing);
  const Outcome run = run_command({"run", "stewart", "--strategy", "groups/cusolver"}, stand_in("no_device"));
  EXPECT_EQ(run.status, 3);
  EXPECT_EQ(run.err, "error: backend cusolver cannot run here: " + missing + "\n");
}

TEST(Gpu, AnOldDriverIsNamed) {
  const Outcome run = run_command({"run", "stewart", "--strategy", "groups/cusolver"}, stand_in("old_driver"));
  EXPECT_EQ(run.status, 3);
  EXPECT_EQ(run.err,
            "error: backend cusolver cannot run here: the NVIDIA driver is too old: it supports CUDA 11.4, and the "
            "libraries are those of 13.0; update the driver, or install an older CUDA\n");
}

TEST(Gpu, ADeviceThatFailsEndsTheRunWithAnError) {
  const Outcome run = run_command({"run", "stewart", "--strategy", "groups/cusolver"}, stand_in("fails"));
  EXPECT_EQ(run.status, 3);
  EXPECT_EQ(run.err, "error: cusolver: cudaStreamSynchronize failed: launch failure\n");
}

TEST(Gpu, MotionsAreThoseOfOtherBackends) {
  for (const char* strategy : {"groups/cusolver", "groups/cusolver:8", "groups/cusolver 2x1", "groups/cusolver+float",
                               "irreducible/cusolver:4+once", "global/cusolver", "groups/magma"}) {
    const Outcome run = run_command(
        {"run", "stewart", "--steps", "50", "--threads", "2", "--strategy", strategy, "--reference", "--json"},
        stand_in("works"));
    ASSERT_EQ(run.status, 0) << strategy << run.err;
    const auto report = run.json();
    EXPECT_EQ(report["strategy"], strategy);
    EXPECT_EQ(report["status"], "ok");
    if (report["error"]["forward_position"].is_null()) continue;  // a build without Boost
    for (const char* error : {"forward_position", "forward_velocity", "forward_acceleration"}) {
      EXPECT_LE(report["error"][error].get<double>(), 1e-13) << strategy << ' ' << error;
    }
  }
}

TEST(Gpu, CheckRunsIt) {
  const auto left_out = [](const char* mode) {
    const Outcome check =
        run_command({"check", "slider_crank:steps=20", "--quick", "--quiet", "--json"}, stand_in(mode));
    EXPECT_EQ(check.status, 0) << check.err;
    return check.json()["left_out"];
  };
  EXPECT_EQ(left_out("works"), nlohmann::json::array());
  EXPECT_EQ(left_out("fails"),
            nlohmann::json::array({"cusolver: cusolver: cudaStreamSynchronize failed: launch failure"}));
}

TEST(Gpu, TheTunerMeasuresItAndTheDispatcherWeighsIt) {
  const Scratch scratch;
  const std::string file = scratch.file("tuning.db"), scene = "rings:legs=2,n=240,terminal=12";
  const std::string unknown = "it was not measured on this machine; assur tune measures it where there is a GPU";
  const Setting works = stand_in("works");
  const auto tune = [&](int seconds) {
    const Outcome tuned = run_tuning(seconds, {"--scene", scene, "--db", file, "--quiet", "--json"}, works);
    ASSERT_EQ(tuned.status, 0) << tuned.err;
    EXPECT_EQ(tuned.json()["left_out"], nlohmann::json::array());
  };
  tune(10);
  std::set<std::string> measured;
  for (const Sample& s : db::Store(file, db::Access::read).samples()) measured.insert(s.strategy.solver.backend);
  EXPECT_EQ(measured.count("cusolver") + measured.count("magma"), 2u);

  // What `plan` says of the backend for the last class: the reason why it is not offered, or "measured" and the like.
  const auto offered = [&](const std::string& of, bool tuned_before, const Setting& setting) {
    std::vector<std::string> words = {"plan", of, "--json"};
    if (tuned_before) words.insert(words.end(), {"--db", file});
    const Outcome plan = run_command(words, setting);
    EXPECT_EQ(plan.status, 0) << plan.err;
    std::string said = "no candidate";
    const nlohmann::json candidates = plan.json()["candidates"];
    for (const auto& candidate : candidates) {
      if (!candidate["strategy"].get<std::string>().ends_with("/cusolver")) continue;  // of any formulation
      const auto why_not = candidate["why_not"].get<std::string>();
      said = why_not.empty() ? candidate["origin"].get<std::string>() : why_not;
    }
    return said;
  };
  // A busy machine needs more time until it comes to every class.
  for (int seconds = 20; seconds <= 160 && offered(scene, true, works) == unknown; seconds *= 2) tune(seconds);
  const std::set<std::string> origins = {"measured", "interpolated", "extrapolated"};  // by the load of the machine
  EXPECT_EQ(origins.count(offered(scene, true, works)), 1u);
  EXPECT_EQ(offered("stewart", true, works), "a GPU is considered from 100 unknowns on");
  EXPECT_EQ(offered(scene, false, works), unknown);
  EXPECT_EQ(offered(scene, true, stand_in("no_device")), unknown);  // samples of another device do not count
}

}  // namespace
}  // namespace assur
