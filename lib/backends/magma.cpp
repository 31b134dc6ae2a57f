// Dense LU by MAGMA (Tomov, Dongarra & Baboulin, Parallel Comput. 36, 2010), which shares the work between the
// processor and a GPU; the paper's version for GPUs uses it. One lane after the other; triangular solutions on the
// processor. MAGMA is loaded at run time; it needs the CUDA (or HIP) that it was built with.
#include <algorithm>
#include <array>
#include <string>

#include "backends/backends.hpp"
#include "backends/dense_lu.hpp"
#include "backends/dense_solver.hpp"
#include "backends/shared_library.hpp"
#include "parallel/thread_state.hpp"

namespace assur::magma {
namespace {

constexpr std::array kNames = {"libmagma.so.2", "libmagma.so"};

// Functions of MAGMA 2 with 32-bit integers; matrices are in the memory of the processor.
struct Library {
  int (*init)() = nullptr;
  void (*version)(int* major, int* minor, int* micro) = nullptr;
  int (*dgetrf)(int m, int n, double* a, int lda, int* pivot, int* info) = nullptr;
  int (*sgetrf)(int m, int n, float* a, int lda, int* pivot, int* info) = nullptr;

  std::string why_not;  // "" if it can run
};

Library load() {
  Library found;
  SharedLibrary in;
  if (std::none_of(kNames.begin(), kNames.end(), [&](const char* name) { return in.open(name); })) {
    found.why_not = "no libmagma.so was found: install MAGMA 2 and put the folder of its library into LD_LIBRARY_PATH";
  } else if (!in.find("magma_init", found.init) || !in.find("magma_version", found.version) ||
             !in.find("magma_dgetrf", found.dgetrf) || !in.find("magma_sgetrf", found.sgetrf)) {
    found.why_not = "libmagma.so has no dense LU (magma_init, magma_version, magma_dgetrf, magma_sgetrf)";
  } else if (const int status = found.init(); status != 0) {
    found.why_not = "MAGMA finds no GPU that it can use (magma_init ends with status " + std::to_string(status) + ")";
  }
  return found;
}

// Loaded once, at the first call.
const Library& library() {
  static const Library loaded = load();
  return loaded;
}

template <class T>
class MagmaLu final : public DenseLu<T> {
 public:
  bool factorize(const Block<T>& a, std::int32_t* pivot) override {
    const BlasThreads threads(1);  // its part on the processor
    const int n = static_cast<int>(a.columns);
    int info = 0;
    if constexpr (std::is_same_v<T, double>) {
      library().dgetrf(n, n, a.data, n, pivot, &info);
    } else {
      library().sgetrf(n, n, a.data, n, pivot, &info);
    }
    if (info < 0) {
      throw Error(Error::Kind::environment, "MAGMA's LU failed with info = " + std::to_string(info) +
                                                "; below -100 this is an error of the GPU, such as too little memory");
    }
    return info == 0;
  }

  void solve(const Block<T>& lu, const std::int32_t* pivot, const Block<T>& x, Transpose transpose,
             DenseIndex first_wanted) override {
    eigen::solve_factored(lu, pivot, x, transpose, first_wanted);
  }
};

}  // namespace

std::string why_not(const Shape& shape, ThreadBudget budget) {
  if (!library().why_not.empty()) return library().why_not;
  return budget.threads > 1 ? "it runs on one thread" : why_not_dense(shape);
}

std::unique_ptr<LinearSolver> make(ThreadBudget, Precision precision) {
  if (!library().why_not.empty()) return nullptr;
  if (precision == Precision::binary32) return make_dense_solver<float>(std::make_unique<MagmaLu<float>>());
  return make_dense_solver<double>(std::make_unique<MagmaLu<double>>());
}

std::string version() {
  if (!library().why_not.empty()) return "";
  std::array<int, 3> v{};
  library().version(&v[0], &v[1], &v[2]);
  return std::to_string(v[0]) + "." + std::to_string(v[1]) + "." + std::to_string(v[2]);
}

}  // namespace assur::magma
