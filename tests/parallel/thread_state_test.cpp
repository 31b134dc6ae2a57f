#include "parallel/thread_state.hpp"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <thread>
#include <vector>

#include "assur/backend.hpp"
#include "assur/status.hpp"
#include "source_dir.hpp"

namespace assur::test {
namespace {

// Asks a backend, because a program that calls no BLAS does not load one.
std::string loaded() { return find_backend(backends(), "lapack").version(); }

class BlasThreadsTest : public testing::Test {
 protected:
  void SetUp() override {
    if (loaded().find(", OpenMP, ") == std::string::npos) GTEST_SKIP() << loaded();
    threads_ = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "omp_get_max_threads"));
    ASSERT_NE(threads_, nullptr);
  }
  int elsewhere() const {
    int threads = 0;
    std::thread([&] { threads = threads_(); }).join();
    return threads;
  }
  int (*threads_)() = nullptr;
};

TEST_F(BlasThreadsTest, SetsThreadsOfTheCallingThreadForAScope) {
  const int before = threads_(), other = elsewhere();
  {
    const BlasThreads three(3);
    EXPECT_EQ(threads_(), 3);
    EXPECT_EQ(elsewhere(), other);
    {
      const BlasThreads one(1);
      EXPECT_EQ(threads_(), 1);
    }
    EXPECT_EQ(threads_(), 3);
  }
  EXPECT_EQ(threads_(), before);
}

TEST_F(BlasThreadsTest, SetsAnyNumberOfThreads) {
  for (int threads : {1, 2, 64}) EXPECT_EQ(why_not_blas_threads(threads), "");
}

// The alternatives of Debian point to the build for pthreads if both builds are installed.
TEST(Blas, TheLinkedBuildIsLoaded) {
#ifdef ASSUR_LINKED_BLAS
  EXPECT_EQ(loaded().rfind(ASSUR_LINKED_BLAS, 0), 0u) << loaded();
  EXPECT_EQ(loaded(), blas_version());
#else
  GTEST_SKIP() << "another LAPACK, or none";
#endif
}

// A core type that is set for OpenBLAS imitates a processor that OpenBLAS does not know.
TEST(Blas, ReportsKernelsWithUnusedInstructions) {
  EXPECT_NE(slow_kernels("Prescott", "AVX3_DL").find("OPENBLAS_CORETYPE=SkylakeX"), std::string::npos);
  EXPECT_NE(slow_kernels("Sandybridge", "AVX2").find("OPENBLAS_CORETYPE=Haswell"), std::string::npos);
  for (const char* core : {"Haswell", "Zen", "SkylakeX", "SapphireRapids", "some core of tomorrow"}) {
    EXPECT_EQ(slow_kernels(core, "AVX3"), "") << core;
  }
  EXPECT_EQ(slow_kernels("Prescott", "SSE4"), "");
  EXPECT_EQ(slow_kernels("Unknown", "NEON"), "");
}

// ---- processors

TEST(Pinned, KeepsTheThreadOnOneProcessorForAScope) {
  const std::vector<int> before = allowed_processors();
  if (before.empty()) GTEST_SKIP() << "the system does not tell where threads may run";
  for (const int processor : before) {
    const Pinned pinned(processor);
    EXPECT_EQ(allowed_processors(), std::vector<int>{processor});
    std::vector<int> of_a_new_thread;
    std::thread([&] { of_a_new_thread = allowed_processors(); }).join();
    EXPECT_EQ(of_a_new_thread, std::vector<int>{processor});
  }
  EXPECT_EQ(allowed_processors(), before);
}

TEST(Pinned, RefusesAMissingProcessor) {
  const std::vector<int> before = allowed_processors();
  EXPECT_THROW(const Pinned pinned(8191), Error);
  EXPECT_EQ(allowed_processors(), before);
}

// ---- source files

TEST(ThreadState, OnlyOneFileChangesIt) {
  const std::regex change(
      "omp_set_|openblas_set_num_threads|goto_set_num_threads|MKL_Set_|mkl_set_|bli_thread_set|"
      "sched_setaffinity|pthread_setaffinity|pthread_attr_setaffinity|setpriority|sched_setscheduler|"
      "pthread_setschedparam|setenv|putenv|pragma omp|omp\\.h");
  const std::filesystem::path lib = std::filesystem::path(ASSUR_SOURCE_DIR) / "lib";
  int files = 0, allowed = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(lib)) {
    if (!entry.is_regular_file()) continue;
    ++files;
    std::ifstream stream(entry.path());
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    std::smatch found;
    if (!std::regex_search(text, found, change)) continue;
    if (std::filesystem::relative(entry.path(), lib) == "parallel/thread_state.cpp") {
      ++allowed;
    } else {
      ADD_FAILURE() << entry.path() << ": " << found.str() << " belongs into lib/parallel/thread_state.cpp";
    }
  }
  EXPECT_EQ(allowed, 1) << "the scan finds what it looks for";
  EXPECT_GT(files, 50);
}

}  // namespace
}  // namespace assur::test
