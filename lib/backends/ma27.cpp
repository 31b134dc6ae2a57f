// HSL MA27 (Duff & Reid 1983), symmetric indefinite LDL', on the augmented matrix. Its licence forbids redistribution,
// so it is loaded at run time from a library that the user has built, under the names that HSL and Ipopt use.
#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "backends/augmented.hpp"
#include "backends/backends.hpp"
#include "backends/shared_library.hpp"

namespace assur::ma27 {
namespace {

constexpr std::array kNames = {"libhsl.so", "libcoinhsl.so"};

// The four routines of MA27, double precision; Fortran passes everything by address.
// Specification: HSL Archive, MA27, version 1.0.0, section 2.1.
struct Library {
  // ICNTL(30), CNTL(5)
  void (*start)(int* icntl, double* cntl) = nullptr;
  // N, NZ, IRN(NZ), ICN(NZ), IW(LIW), LIW, IKEEP(N, 3), IW1(N, 2), NSTEPS, IFLAG, ICNTL, CNTL, INFO(20), OPS
  void (*analyze)(const int* n, const int* nz, const int* irn, const int* icn, int* iw, const int* liw, int* ikeep,
                  int* iw1, int* nsteps, int* iflag, int* icntl, double* cntl, int* info, double* ops) = nullptr;
  // N, NZ, IRN, ICN, A(LA), LA, IW(LIW), LIW, IKEEP, NSTEPS, MAXFRT, IW1(N), ICNTL, CNTL, INFO
  void (*factorize)(const int* n, const int* nz, const int* irn, const int* icn, double* a, const int* la, int* iw,
                    const int* liw, int* ikeep, const int* nsteps, int* maxfrt, int* iw1, int* icntl, double* cntl,
                    int* info) = nullptr;
  // N, A, LA, IW, LIW, W(MAXFRT), MAXFRT, RHS(N), IW1(NSTEPS), NSTEPS, ICNTL, INFO
  void (*solve)(const int* n, double* a, const int* la, int* iw, const int* liw, double* w, const int* maxfrt,
                double* rhs, int* iw1, const int* nsteps, int* icntl, int* info) = nullptr;

  std::string why_not;  // "" if all four were found
};

Library load() {
  Library found;
  for (const char* name : kNames) {
    SharedLibrary in;
    if (!in.open(name)) continue;
    if (in.find("ma27id_", found.start) && in.find("ma27ad_", found.analyze) && in.find("ma27bd_", found.factorize) &&
        in.find("ma27cd_", found.solve)) {
      found.why_not.clear();
      return found;
    }
    in.close();
    found.why_not = std::string(name) + " has no MA27 in double precision (ma27id_, ma27ad_, ma27bd_, ma27cd_)";
  }
  if (found.why_not.empty()) found.why_not = "no libhsl.so or libcoinhsl.so was found";
  found.why_not +=
      ": get HSL MA27 (Coin-HSL, free for academic use) from https://www.hsl.rl.ac.uk, build it as a "
      "shared library and put its folder into LD_LIBRARY_PATH";
  return found;
}

// Loaded once, at the first call.
const Library& library() {
  static const Library loaded = load();
  return loaded;
}

constexpr double kThreshold = 0.5;  // largest value for 2 x 2 pivots: least growth
constexpr int kHeadroom = 2;        // factor of the workspace that definite matrices need

class Ma27 final : public SymmetricSolver {
 public:
  void analyze(int order, std::span<int> row, std::span<int> column) override;
  Code factorize(std::span<const double> values) override;
  void solve(std::span<double> b_to_x, int rhs) override;

 private:
  // INFO(1)
  enum : int { kIntegerWorkspace = -3, kRealWorkspace = -4, kZeroPivot = -5, kRankDeficient = 3 };

  [[noreturn]] void fail() const;

  const Library& library_ = library();
  std::array<int, 30> icntl_{};
  std::array<double, 5> cntl_{};
  std::array<int, 20> info_{};
  int order_ = 0, nonzeros_ = 0, steps_ = 0, front_ = 0;
  std::span<int> row_, column_;       // nonzeros
  std::vector<int> keep_;             // 3 x order
  std::vector<int> work_;             // 2 x order
  std::vector<int> integers_;         // structure of the factors
  std::vector<double> factors_;       // values first, then the factors
  std::vector<double> front_values_;  // at most order
};

void Ma27::analyze(int order, std::span<int> row, std::span<int> column) {
  order_ = order;
  nonzeros_ = static_cast<int>(row.size());
  row_ = row;
  column_ = column;
  const auto n = static_cast<std::size_t>(order);
  library_.start(icntl_.data(), cntl_.data());
  icntl_[0] = icntl_[1] = icntl_[2] = 0;  // print nothing
  cntl_[0] = kThreshold;
  keep_.resize(3 * n);
  work_.resize(2 * n);
  front_values_.resize(n);
  integers_.resize(kHeadroom * (2 * row.size() + 3 * n + 1));
  const int size = static_cast<int>(integers_.size());
  int choose_order = 0;
  double operations = 0;
  library_.analyze(&order_, &nonzeros_, row_.data(), column_.data(), integers_.data(), &size, keep_.data(),
                   work_.data(), &steps_, &choose_order, icntl_.data(), cntl_.data(), info_.data(), &operations);
  if (info_[0] < 0) fail();
  // INFO(5), INFO(6): workspace that is enough without exchanges of pivots
  factors_.resize(std::max(row.size() + n, kHeadroom * static_cast<std::size_t>(std::max(info_[4], 0))));
  integers_.resize(std::max(row.size() + n, kHeadroom * static_cast<std::size_t>(std::max(info_[5], 0))));
}

Code Ma27::factorize(std::span<const double> values) {
  for (;;) {
    std::copy(values.begin(), values.end(), factors_.begin());
    const int reals = static_cast<int>(factors_.size()), integers = static_cast<int>(integers_.size());
    library_.factorize(&order_, &nonzeros_, row_.data(), column_.data(), factors_.data(), &reals, integers_.data(),
                       &integers, keep_.data(), &steps_, &front_, work_.data(), icntl_.data(), cntl_.data(),
                       info_.data());
    switch (info_[0]) {
      case kIntegerWorkspace:
        integers_.resize(2 * integers_.size());
        continue;
      case kRealWorkspace:
        factors_.resize(2 * factors_.size());
        continue;
      case kZeroPivot:
      case kRankDeficient:
        return Code::singular;
      default:
        break;
    }
    if (info_[0] < 0) fail();
    return Code::ok;
  }
}

void Ma27::solve(std::span<double> b_to_x, int rhs) {
  const int reals = static_cast<int>(factors_.size()), integers = static_cast<int>(integers_.size());
  for (int r = 0; r < rhs; ++r) {
    library_.solve(&order_, factors_.data(), &reals, integers_.data(), &integers, front_values_.data(), &front_,
                   b_to_x.data() + static_cast<std::size_t>(r) * static_cast<std::size_t>(order_), work_.data(),
                   &steps_, icntl_.data(), info_.data());
  }
}

void Ma27::fail() const {
  throw Error(Error::Kind::environment,
              "MA27 failed with INFO(1) = " + std::to_string(info_[0]) + ", INFO(2) = " + std::to_string(info_[1]));
}

}  // namespace

std::string why_not(const Shape&, ThreadBudget budget) {
  return library().why_not.empty() && budget.threads > 1 ? "it runs on one thread" : library().why_not;
}

std::unique_ptr<LinearSolver> make(ThreadBudget, Precision) {
  if (!library().why_not.empty()) return nullptr;
  return make_augmented([]() -> std::unique_ptr<SymmetricSolver> { return std::make_unique<Ma27>(); });
}

// HSL does not report a version; this one is that of the specification.
std::string version() { return library().why_not.empty() ? "1.0.0" : ""; }

}  // namespace assur::ma27
