#include "backends/contract_cases.hpp"

#include <limits>

#include "numbers.hpp"

namespace assur::test {
namespace {

Matrix scaled(Matrix a, const std::function<double(int, int)>& factor) {
  scale(a, factor);
  return a;
}
double power(int i) { return i % 2 ? 1e150 : 1e-150; }
Matrix one_by_one(double value) {
  return compress(
      1, [](int, int) { return true; }, [value](int, int) { return value; });
}

std::vector<Case> regular() {
  std::vector<Case> table = {
      {"empty", [](Random& r) { return dense(0, r); }},
      {"ring24", [](Random& r) { return ring(24, r); }},
      {"ring120", [](Random& r) { return ring(120, r); }},
      {"zero_diagonal",
       [](Random& r) {
         return compress(
             15, [](int i, int j) { return i != j; }, [&](int, int) { return nonzero(r); });
       }},
      {"zero_values_on_the_diagonal",
       [](Random& r) { return scaled(dense(15, r), [](int i, int j) { return i != j; }); }},
      {"permuted_triangle", [](Random& r) { return permuted_triangle(40, 1, r); }},
      {"block_triangle", [](Random& r) { return permuted_triangle(40, 4, r); }},
      {"kahan", [](Random&) { return kahan(30, 1.2); }},
  };
  for (int n : {1, 2, 3, 15, 40, 102}) {
    table.push_back({"dense" + std::to_string(n), [n](Random& r) { return dense(n, r); }});
  }
  for (int n : {3, 15, 40, 102}) {
    table.push_back({"sparse" + std::to_string(n), [n](Random& r) { return sparse(n, 1 + n / 15, r); }});
  }
  return table;
}

std::vector<Case> badly_scaled() {
  return {
      {"rows_scaled", [](Random& r) { return scaled(dense(15, r), [](int i, int) { return power(i); }); }},
      {"columns_scaled", [](Random& r) { return scaled(dense(15, r), [](int, int j) { return power(j); }); }},
      {"all_tiny", [](Random& r) { return scaled(sparse(15, 2, r), [](int, int) { return 1e-150; }); }},
      {"all_huge", [](Random& r) { return scaled(sparse(15, 2, r), [](int, int) { return 1e150; }); }},
      {"graded_down", [](Random& r) { return scaled(dense(15, r), [](int i, int j) { return std::pow(8, -i - j); }); }},
      {"graded_up",
       [](Random& r) { return scaled(dense(15, r), [](int i, int j) { return std::pow(8, i + j - 28); }); }},
  };
}

// Backward errors do not depend on the condition, so all these matrices are solved. Conditions above 1 / eps may also
// be reported as singular.
std::vector<Case> ill_conditioned() {
  std::vector<Case> table;
  for (int n = 4; n <= 12; ++n) {
    Case hilbert_case{"hilbert" + std::to_string(n), [n](Random&) { return hilbert(n); }};
    hilbert_case.condition = std::pow(33.0, n - 1);  // grows by (1 + sqrt 2)^4 with each n
    table.push_back(std::move(hilbert_case));
  }
  for (int exponent : {2, 4, 6, 8, 10, 12, 14, 15, 16, 17}) {
    Case one{"condition1e" + std::to_string(exponent),
             [exponent](Random& r) { return with_condition(12, std::pow(10, exponent), r); },
             exponent < 16 ? Outcome::solved : Outcome::either};
    one.condition = std::pow(10, exponent);
    table.push_back(std::move(one));
  }
  Case row{"nearly_zero_row",
           [](Random& r) { return scaled(dense(15, r), [](int i, int) { return i == 7 ? 1e-14 : 1.0; }); }};
  table.push_back(std::move(row));
  return table;
}

// Pivots grow by 2^(n - 1) under partial pivoting. Other orders of rows and columns may avoid this growth.
std::vector<Case> growing() {
  Case wilkinson_case{"wilkinson60", [](Random&) { return wilkinson(60); }, Outcome::grows};
  wilkinson_case.growth = std::pow(2, 59);
  Case gfpp_case{"gfpp40", [](Random& r) { return gfpp(40, r); }, Outcome::grows};
  gfpp_case.growth = std::pow(2, 39);
  return {wilkinson_case, gfpp_case};
}

// The elimination of small whole numbers ends at an exact zero. Exceptions are symmetric solvers, scaling by numbers
// that are not powers of 2, and devices, which may multiply by inverse pivots.
constexpr double kNoSign = std::numeric_limits<double>::infinity();  // a condition: signs are not tested
const std::map<std::string_view, Outcome> kInexact = {
    {"umfpack", Outcome::either},  {"mumps", Outcome::either}, {"ma27", Outcome::either},
    {"cusolver", Outcome::either}, {"magma", Outcome::either}, {"symmetric_mumps", Outcome::either}};

std::vector<Case> refused() {
  return {
      {"zero1", [](Random&) { return one_by_one(0); }, Outcome::singular},
      {"zero_row", [](Random& r) { return scaled(dense(15, r), [](int i, int) { return i != 7; }); },
       Outcome::singular},
      {"zero_column", [](Random& r) { return scaled(sparse(15, 3, r), [](int, int j) { return j != 7; }); },
       Outcome::singular},
      {"all_zero", [](Random& r) { return scaled(sparse(15, 3, r), [](int, int) { return 0; }); }, Outcome::singular},
      {"repeated_row3", [](Random& r) { return repeated_row(3, r); }, Outcome::singular, kInexact, kNoSign},
      {"repeated_row15", [](Random& r) { return repeated_row(15, r); }, Outcome::singular, kInexact, kNoSign},
      {"empty_column",  // singular for all values of its entries
       [](Random& r) {
         return compress(
             6, [](int, int j) { return j != 3; }, [&](int, int) { return nonzero(r); });
       },
       Outcome::singular},
      {"no_nonzeros",
       [](Random&) {
         return compress(
             3, [](int, int) { return false; }, [](int, int) { return 0; });
       },
       Outcome::singular},
      {"two_columns_share_their_only_row",
       [](Random& r) {
         return compress(
             6, [](int i, int j) { return j > 1 || i == 4; }, [&](int, int) { return nonzero(r); });
       },
       Outcome::singular},
      {"nan", [](Random& r) { return scaled(sparse(15, 3, r), [](int i, int) { return i == 7 ? kNan : 1.0; }); },
       Outcome::not_finite},
      {"infinity",
       [](Random& r) { return scaled(sparse(15, 3, r), [](int, int j) { return j == 7 ? kInfinity : 1.0; }); },
       Outcome::not_finite},
      {"nan1", [](Random&) { return one_by_one(kNan); }, Outcome::not_finite},
      {"infinity1", [](Random&) { return one_by_one(-kInfinity); }, Outcome::not_finite},
  };
}

}  // namespace

const std::vector<Case>& cases() {
  static const std::vector<Case> table = [] {
    std::vector<Case> all;
    for (const auto& part : {regular(), badly_scaled(), ill_conditioned(), growing(), refused()}) {
      all.insert(all.end(), part.begin(), part.end());
    }
    return all;
  }();
  return table;
}

Told told_by(std::string_view id) {
  static const std::map<std::string_view, Told> table = {
      {"eigen", {.partial_pivoting = true}},
      {"lapack", {.partial_pivoting = true}},
      {"team", {.partial_pivoting = true}},
      {"cusolver", {.partial_pivoting = true}},
      {"magma", {.partial_pivoting = true}},
      {"mumps", {.growth = false}},
      {"ma27", {.growth = false, .condition = false, .sign = false}},
      {"symmetric_mumps", {.growth = false, .condition = false, .sign = false}},
  };
  const auto found = table.find(id);
  return found == table.end() ? Told{} : found->second;
}

}  // namespace assur::test
