#include "parallel/thread_state.hpp"

#include <dlfcn.h>
#include <pthread.h>
#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <string>

#include "assur/status.hpp"
#include "parallel/instruction_set.hpp"

namespace assur {
namespace {

template <class Function>
Function* find(const char* symbol) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, symbol));
}

// Functions of the loaded library; null if it lacks them. Looked up instead of linked, so that one program runs with
// any library.
struct Library {
  // sets the number of this thread; returns the previous one
  int (*mkl_set_threads)(int) = find<int(int)>("MKL_Set_Num_Threads_Local");
  void (*mkl_version)(char*, int) = find<void(char*, int)>("MKL_Get_Version_String");

  int (*openblas_parallel)() = find<int()>("openblas_get_parallel");
  int (*openblas_threads)() = find<int()>("openblas_get_num_threads");
  void (*openblas_set_threads)(int) = find<void(int)>("openblas_set_num_threads");
  char* (*openblas_config)() = find<char*()>("openblas_get_config");
  char* (*openblas_core)() = find<char*()>("openblas_get_corename");

  // The OpenMP build of OpenBLAS asks OpenMP for the number of threads of the calling thread. If this is not 1, the
  // build stores it for the whole process, as openblas_set_num_threads() does.
  int (*omp_threads)() = find<int()>("omp_get_max_threads");
  void (*omp_set_threads)(int) = find<void(int)>("omp_set_num_threads");
  int (*omp_in_parallel)() = find<int()>("omp_in_parallel");

  enum class Kind { mkl, openmp, pthreads, sequential, unknown } kind = Kind::unknown;

  Library() {
    if (mkl_set_threads) {
      kind = Kind::mkl;
    } else if (openblas_parallel && openblas_threads && openblas_set_threads && openblas_config && openblas_core) {
      switch (openblas_parallel()) {
        case 0:
          kind = Kind::sequential;
          break;
        case 1:
          kind = Kind::pthreads;
          break;
        case 2:
          if (omp_threads && omp_set_threads && omp_in_parallel) kind = Kind::openmp;
          break;
        default:
          break;
      }
    }
  }
};

const Library& library() {
  static const Library found;
  return found;
}

// Keeps OpenBLAS's number of threads, of which the process has only one, from the start of the first of several
// concurrent calls to the end of the last; otherwise they would overwrite it.
class ProcessNumber {
 public:
  void borrow(const Library& blas) {
    State state = state_.load();
    while (!state_.compare_exchange_weak(
        state, {state.borrowers + 1, state.borrowers == 0 ? blas.openblas_threads() : state.before})) {
    }
  }
  void give_back(const Library& blas) {
    State state = state_.load();
    do {
      const bool last = state.borrowers == 1;  // set before the count falls to 0: a new borrower keeps `before`
      if (last && blas.openblas_threads() != state.before) blas.openblas_set_threads(state.before);
    } while (!state_.compare_exchange_weak(state, {state.borrowers - 1, state.before}));
  }

 private:
  struct alignas(8) State {  // without alignas clang calls a library for atomics
    int borrowers = 0, before = 0;
  };
  std::atomic<State> state_;
};
ProcessNumber process_number;

}  // namespace

std::string blas_version() {
  const Library& blas = library();
  if (blas.kind == Library::Kind::mkl) {
    std::array<char, 200> text{};
    if (blas.mkl_version) blas.mkl_version(text.data(), static_cast<int>(text.size()) - 1);
    const std::string version = text.data();
    return version.substr(0, version.find_last_not_of(' ') + 1);
  }
  if (!blas.openblas_config || !blas.openblas_core) return "LAPACK";
  const std::string config = blas.openblas_config();  // "OpenBLAS 0.3.21 NO_LAPACKE DYNAMIC_ARCH ..."
  const auto number = config.find(' ');
  const char* threads = blas.kind == Library::Kind::openmp       ? "OpenMP"
                        : blas.kind == Library::Kind::pthreads   ? "pthreads"
                        : blas.kind == Library::Kind::sequential ? "one thread"
                                                                 : "threads unknown";
  return config.substr(0, config.find(' ', number + 1)) + ", " + threads + ", " + blas.openblas_core();
}

std::string blas_slowed() {
  const Library& blas = library();
  return blas.openblas_core ? slow_kernels(blas.openblas_core(), instruction_set()) : "";
}

std::string slow_kernels(std::string_view core, std::string_view instructions) {
  // Unlisted names may belong to newer processors.
  constexpr std::array<std::string_view, 21> kWithoutAvx2 = {
      "Unknown", "Katmai",    "Coppermine", "Northwood",    "Prescott",  "Banias",      "Atom",
      "Core2",   "Penryn",    "Dunnington", "Nehalem",      "Athlon",    "Nano",        "Opteron",
      "Bobcat",  "Bulldozer", "Piledriver", "Opteron_SSE3", "Barcelona", "Sandybridge", "Steamroller"};
  const bool serves = std::find(kWithoutAvx2.begin(), kWithoutAvx2.end(), core) == kWithoutAvx2.end();
  if (serves || !instructions.starts_with("AVX")) return "";
  return "OpenBLAS does not know this processor, treats it as " + std::string(core) +
         " and leaves its wider instructions unused: set OPENBLAS_CORETYPE=" +
         (instructions.starts_with("AVX3") ? "SkylakeX" : "Haswell");
}

std::string why_not_blas_memory() {
  const Library& blas = library();
  if (!blas.openblas_threads) return "";
  const int threads = std::max(blas.openblas_threads(), 1);
  const std::size_t bytes = static_cast<std::size_t>(threads) * kBlasBuffer;
  void* const room = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (room != MAP_FAILED) {
    munmap(room, bytes);
    return "";
  }
  return "OpenBLAS cannot reserve the address space that it needs, " + std::to_string(bytes >> 20) + " MiB for " +
         std::to_string(threads) + (threads == 1 ? " thread" : " threads") +
         "; raise `ulimit -v`, or set OMP_NUM_THREADS=1";
}

std::string why_not_blas_threads(int threads) {
  if (std::string no_room = why_not_blas_memory(); !no_room.empty()) return no_room;
  const Library& blas = library();
  const std::string wanted = std::to_string(threads) + (threads == 1 ? " thread" : " threads");
  switch (blas.kind) {
    case Library::Kind::mkl:
      return "";
    case Library::Kind::openmp:
      if (threads == 1 || !blas.omp_in_parallel()) return "";
      return blas_version() + " uses one thread within an OpenMP parallel region, not " + std::to_string(threads);
    case Library::Kind::pthreads: {
      const int all = blas.openblas_threads();
      if (threads == all) return "";
      return blas_version() +
             " is loaded, which has one number of threads for the whole process: " + std::to_string(all) + ", not " +
             std::to_string(threads) + "; set OPENBLAS_NUM_THREADS=" + std::to_string(threads) +
             ", or let the loader find the OpenMP build (Debian: libopenblas0-openmp)";
    }
    case Library::Kind::sequential:
      if (threads == 1) return "";
      return blas_version() + " is loaded, which cannot use " + wanted;
    case Library::Kind::unknown:
      // An unknown library is taken to use one thread, like the reference implementation.
      if (threads == 1) return "";
      return "the threads of the LAPACK library that is loaded cannot be set to " + std::to_string(threads) +
             "; OpenBLAS (its OpenMP build) and MKL can";
  }
  return "";
}

BlasThreads::BlasThreads(int threads) {
  const Library& blas = library();
  if (blas.kind == Library::Kind::mkl) {
    before_ = blas.mkl_set_threads(threads);
  } else if (blas.kind == Library::Kind::openmp) {
    before_ = blas.omp_threads();
    shares_ = threads != 1;
    if (shares_) process_number.borrow(blas);
    if (before_ != threads) blas.omp_set_threads(threads);
  }
}

BlasThreads::~BlasThreads() {
  const Library& blas = library();
  if (blas.kind == Library::Kind::mkl) {
    blas.mkl_set_threads(before_);
  } else if (blas.kind == Library::Kind::openmp) {
    if (shares_) process_number.give_back(blas);
    if (blas.omp_threads() != before_) blas.omp_set_threads(before_);
  }
}

std::vector<int> allowed_processors() {
  std::array<cpu_set_t, 8> set{};
  std::vector<int> processors;
  if (pthread_getaffinity_np(pthread_self(), sizeof(set), set.data()) != 0) return processors;
  for (int processor = 0; processor < static_cast<int>(8 * sizeof(set)); ++processor) {
    if (CPU_ISSET_S(static_cast<unsigned>(processor), sizeof(set), set.data())) processors.push_back(processor);
  }
  return processors;
}

Pinned::Pinned(int processor) : before_{} {
  std::array<cpu_set_t, 8> one{};
  CPU_SET_S(static_cast<unsigned>(processor), sizeof(one), one.data());
  int failure = pthread_getaffinity_np(pthread_self(), sizeof(before_), before_.data());
  if (failure == 0 && CPU_EQUAL_S(sizeof(one), before_.data(), one.data())) return;
  if (failure == 0) failure = pthread_setaffinity_np(pthread_self(), sizeof(one), one.data());
  changed_ = failure == 0;
  if (failure != 0) {
    throw Error(Error::Kind::environment, "cannot pin a thread to processor " + std::to_string(processor) + ": " +
                                              std::strerror(failure) + "; pin to processors that this process may use");
  }
}

// Fails if this process may no longer use the earlier processors; the thread then runs on any that is left.
Pinned::~Pinned() {
  if (changed_) pthread_setaffinity_np(pthread_self(), sizeof(before_), before_.data());
}

}  // namespace assur
