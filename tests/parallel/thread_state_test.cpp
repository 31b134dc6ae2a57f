#include "parallel/thread_state.hpp"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <thread>

#include "assur/backend.hpp"

namespace assur::test {
namespace {

// By way of the table: a program that calls no BLAS does not load one.
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

TEST_F(BlasThreadsTest, AreThoseOfTheCallingThreadUntilTheEndOfTheScope) {
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

TEST_F(BlasThreadsTest, AnyNumberCanBeHad) {
  for (int threads : {1, 2, 64}) EXPECT_EQ(why_not_blas_threads(threads), "");
}

// Debian's alternatives point to the build for pthreads where both are installed.
TEST(Blas, TheBuildThatWasLinkedIsTheOneThatIsLoaded) {
#ifdef ASSUR_LINKED_BLAS
  EXPECT_EQ(loaded().rfind(ASSUR_LINKED_BLAS, 0), 0u) << loaded();
  EXPECT_EQ(loaded(), blas_version());
#else
  GTEST_SKIP() << "another LAPACK, or none";
#endif
}

}  // namespace
}  // namespace assur::test
