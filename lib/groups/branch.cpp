#include "groups/branch.hpp"

#include <algorithm>
#include <cmath>

#include "backends/backends.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "program/step_rules.hpp"

namespace assur {
namespace {

constexpr std::int32_t kDenseInverse = 64;  // unknowns of a block; norms of inverses of larger ones are estimated
constexpr int kHagerRounds = 3;             // a choice: Hager's estimate usually ends after two

// out = a^-1 by Gauss-Jordan with row pivoting (column-major, n x n; a is overwritten). False: singular.
bool invert_dense(double* a, double* out, std::int32_t n) {
  std::fill_n(out, idx(n) * idx(n), 0.0);
  for (std::int32_t i = 0; i < n; ++i) out[i * n + i] = 1;
  for (std::int32_t c = 0; c < n; ++c) {
    std::int32_t pivot = c;
    for (std::int32_t r = c + 1; r < n; ++r) {
      if (std::abs(a[c * n + r]) > std::abs(a[c * n + pivot])) pivot = r;
    }
    const double p = a[c * n + pivot];
    if (!(std::abs(p) > 0) || !std::isfinite(p)) return false;
    if (pivot != c) {
      for (std::int32_t j = 0; j < n; ++j) {
        std::swap(a[j * n + c], a[j * n + pivot]);
        std::swap(out[j * n + c], out[j * n + pivot]);
      }
    }
    const double reciprocal = 1 / p;
    for (std::int32_t j = 0; j < n; ++j) {
      a[j * n + c] *= reciprocal;
      out[j * n + c] *= reciprocal;
    }
    // The columns of a up to c are not needed any more, so that column c can hold the factors of the rows.
    double* const factor = a + c * n;
    factor[c] = 0;
    const auto eliminate = [&](double* column) {
      const double by = column[c];
      if (by == 0) return;
      for (std::int32_t r = 0; r < n; ++r) column[r] -= factor[r] * by;
    };
    for (std::int32_t j = c + 1; j < n; ++j) eliminate(a + j * n);
    for (std::int32_t j = 0; j < n; ++j) eliminate(out + j * n);
  }
  return true;
}

// The largest of n positive numbers of a lane; infinite if one of them, or their sum, is not finite.
double largest_of(const std::vector<double>& numbers, std::size_t n, std::size_t lanes = 1, std::size_t lane = 0) {
  double most = 0, sum = 0;
  for (std::size_t i = lane; i < n * lanes; i += lanes) {
    most = std::max(most, numbers[i]);
    sum += numbers[i];
  }
  return std::isfinite(sum) ? most : kInfinity;
}

}  // namespace

BlockConditions::BlockConditions(const GroupClass& group_class, int lanes, bool by_solver)
    : class_(group_class), lanes_(lanes), by_solver_(by_solver), boxes_(make_box_test(group_class)) {
  std::vector<std::int32_t> column(idx(group_class.n)),
      row(idx(group_class.n));  // of unknowns and equations, within their blocks
  std::vector<std::vector<std::int32_t>> unknowns(idx(group_class.blocks)), equations(idx(group_class.blocks));
  std::vector<std::vector<BoxTest::JacobianEntry>> entries(idx(group_class.blocks));
  for (std::int32_t i = 0; i < group_class.n; ++i) {
    auto& u = unknowns[idx(group_class.unknown_block[idx(i)])];
    column[idx(i)] = static_cast<std::int32_t>(u.size());
    u.push_back(i);
    auto& e = equations[idx(group_class.equation_block[idx(i)])];
    row[idx(i)] = static_cast<std::int32_t>(e.size());
    e.push_back(i);
  }
  for (std::int32_t c = 0; c < group_class.n; ++c) {
    const std::int32_t b = group_class.unknown_block[idx(c)];
    for (std::int32_t k = group_class.pattern.column_start[idx(c)]; k < group_class.pattern.column_start[idx(c) + 1];
         ++k) {
      const std::size_t r = idx(group_class.pattern.row[idx(k)]);
      if (group_class.equation_block[r] == b) entries[idx(b)].push_back({k, row[r], column[idx(c)]});
    }
  }
  unknown_start_ = entry_start_ = {0};
  std::int32_t largest = 0;
  bool needs_vector = false;
  for (std::int32_t b = 0; b < group_class.blocks; ++b) {
    unknowns_.insert(unknowns_.end(), unknowns[idx(b)].begin(), unknowns[idx(b)].end());
    equations_.insert(equations_.end(), equations[idx(b)].begin(), equations[idx(b)].end());
    entries_.insert(entries_.end(), entries[idx(b)].begin(), entries[idx(b)].end());
    unknown_start_.push_back(static_cast<std::int32_t>(unknowns_.size()));
    entry_start_.push_back(static_cast<std::int32_t>(entries_.size()));
    if (!is_large(b)) largest = std::max(largest, size(b));
    needs_vector = needs_vector || needs_solver(b);
  }
  matrix_.resize(idx(largest) * idx(largest));
  inverse_.resize(matrix_.size());
  inverted_.assign(matrix_.size(), kNan);
  for (std::vector<double>* v : {&of_lipschitz_, &of_scale_}) v->resize(idx(largest) * idx(lanes));
  if (needs_vector) vector_.resize(kRightSides * idx(group_class.n) * idx(lanes));
  find_reads(group_class);
}

void BlockConditions::find_reads(const GroupClass& c) {
  std::vector<std::int32_t> last(idx(c.n + c.inputs), -1);  // block that has listed the coordinate already
  std::vector<std::vector<std::int32_t>> reads(idx(c.blocks));
  const auto take = [&](std::int32_t coordinate, std::int32_t b) {
    const bool moves = coordinate < c.n || (coordinate < c.one() && c.input_moves[idx(coordinate - c.n)] != 0);
    if (!moves || last[idx(coordinate)] == b) return;
    last[idx(coordinate)] = b;
    reads[idx(b)].push_back(coordinate);
  };
  const auto take_register = [&](std::int32_t reg, std::int32_t b) {
    if (reg <= c.one()) return take(reg, b);
    const GroupClass::Form& f = c.forms[idx(reg - c.one() - 1)];  // the last registers, in order
    for (std::int32_t o = f.begin; o < f.end; ++o) take(c.operands[idx(o)].reg, b);
  };
  const auto take_arguments = [&](const std::vector<std::int32_t>& arguments, std::int32_t b) {
    for (const std::int32_t argument : arguments) {
      if (argument >= 0) take_register(argument, b);
    }
  };
  for (std::size_t i = 0; i < c.equations.size(); ++i) {
    const GroupClass::Equation& e = c.equations[i];
    const std::int32_t b = c.equation_block[i];
    for (std::int32_t o = e.linear.begin; o < e.linear.end; ++o) take_register(c.linear[idx(o)].reg, b);
    for (std::int32_t o = e.products.begin; o < e.products.end; ++o) {
      take_register(c.products[idx(o)].a, b);
      take_register(c.products[idx(o)].b, b);
    }
    if (e.gear >= 0) take_arguments(c.gears[idx(e.gear)].arguments, b);
  }
  for (const GroupClass::CallbackUse& use : c.callbacks) {
    for (const GroupClass::CallbackUse::EquationOfRow& r : use.rows)
      take_arguments(use.arguments, c.equation_block[idx(r.equation)]);
  }
  reads_start_ = {0};
  for (const auto& r : reads) {
    reads_.insert(reads_.end(), r.begin(), r.end());
    reads_start_.push_back(static_cast<std::int32_t>(reads_.size()));
  }
}

bool BlockConditions::is_large(std::int32_t b) const { return size(b) > kDenseInverse; }

std::span<const std::int32_t> BlockConditions::unknowns(std::int32_t b) const {
  return {unknowns_.data() + unknown_start_[idx(b)], idx(size(b))};
}
std::span<const std::int32_t> BlockConditions::equations(std::int32_t b) const {
  return {equations_.data() + unknown_start_[idx(b)], idx(size(b))};
}

void BlockConditions::extract(const double* jacobian, std::int32_t b, int lane, std::vector<double>& out) const {
  const std::int32_t n = size(b);
  std::fill_n(out.data(), idx(n) * idx(n), 0.0);
  for (const BoxTest::JacobianEntry& e : entries(b))
    out[idx(e.column * n + e.row)] = jacobian[e.nonzero * lanes_ + lane];
}

// Computes the inverse of matrix_, which is overwritten. The test of a tube and the new anchor after it have the same.
bool BlockConditions::invert_matrix(std::int32_t n) {
  const std::ptrdiff_t size = std::ptrdiff_t{n} * n;
  if (std::equal(matrix_.begin(), matrix_.begin() + size, inverted_.begin())) return true;
  std::copy_n(matrix_.begin(), size, inverted_.begin());
  if (invert_dense(matrix_.data(), inverse_.data(), n)) return true;
  inverted_[0] = kNan;  // equals nothing
  return false;
}

void BlockConditions::measure(std::int32_t b, const double* jacobian, const Weights& weights, LinearSolver* solver,
                              const Norms& norms, std::span<const std::uint8_t> lanes) {
  if (is_large(b)) {
    sparse_norms(b, weights.lipschitz, *solver, norms.omega);
    for (int w = 0; w < lanes_; ++w) {
      double ratio = 0;
      for (const std::int32_t r : equations(b)) {
        const double k = weights.lipschitz[r * lanes_ + w];
        if (k > 0) ratio = std::max(ratio, weights.scale[r * lanes_ + w] / k);
      }
      norms.scale[w] = norms.omega[w] * ratio;
    }
    return;
  }
  const bool by_solver = needs_solver(b, jacobian, lanes);
  for (int w = 0; w < lanes_; ++w) {
    if (!lanes.empty() && lanes[idx(w)] == 0) continue;
    if (!by_solver || has_inverse(b, w, jacobian)) dense_norms(b, w, jacobian, weights, norms);
  }
  if (by_solver) norms_by_solver(b, weights, *solver, norms, jacobian, lanes);
}

bool BlockConditions::needs_solver(std::int32_t b, const double* jacobian, std::span<const std::uint8_t> lanes) {
  if (is_large(b) || !needs_solver(b)) return is_large(b);
  for (int w = 0; w < lanes_; ++w) {
    if ((lanes.empty() || lanes[idx(w)] != 0) && !has_inverse(b, w, jacobian)) return true;
  }
  return false;
}

bool BlockConditions::has_inverse(std::int32_t b, int lane, const double* jacobian) {
  if (std::isnan(inverted_[0])) return false;
  extract(jacobian, b, lane, matrix_);
  return std::equal(matrix_.begin(), matrix_.begin() + std::ptrdiff_t{size(b)} * size(b), inverted_.begin());
}

// For the lanes that have no inverse.
void BlockConditions::norms_by_solver(std::int32_t b, const Weights& weights, LinearSolver& solver, const Norms& norms,
                                      const double* jacobian, std::span<const std::uint8_t> lanes) {
  const auto rows = equations(b), columns = unknowns(b);
  const std::size_t w = idx(lanes_), n = idx(class_.n) * w;  // n: of a right-hand side
  for (std::vector<double>* v : {&of_lipschitz_, &of_scale_}) std::fill_n(v->begin(), rows.size() * w, 0.0);
  for (std::size_t first = 0; first < rows.size(); first += kRightSides) {
    const std::size_t some = std::min<std::size_t>(kRightSides, rows.size() - first);
    std::fill_n(vector_.begin(), some * n, 0.0);
    for (std::size_t k = 0; k < some; ++k) std::fill_n(vector_.data() + k * n + idx(rows[first + k]) * w, w, 1.0);
    (void)solver.solve(std::span(vector_).first(some * n), static_cast<int>(some));  // NaN where a lane is singular
    for (std::size_t k = 0; k < some; ++k) {
      const std::size_t row = idx(rows[first + k]) * w;
      for (std::size_t r = 0; r < columns.size(); ++r) {
        const double* const entries = vector_.data() + k * n + idx(columns[r]) * w;
        for (std::size_t l = 0; l < w; ++l) {
          of_lipschitz_[r * w + l] += std::abs(entries[l]) * weights.lipschitz[row + l];
          of_scale_[r * w + l] += std::abs(entries[l]) * weights.scale[row + l];
        }
      }
    }
  }
  for (int l = 0; l < lanes_; ++l) {
    if ((!lanes.empty() && lanes[idx(l)] == 0) || has_inverse(b, l, jacobian)) continue;
    norms.omega[l] = largest_of(of_lipschitz_, columns.size(), w, idx(l));
    norms.scale[l] = largest_of(of_scale_, columns.size(), w, idx(l));
  }
}

void BlockConditions::dense_norms(std::int32_t b, int lane, const double* jacobian, const Weights& weights,
                                  const Norms& norms) {
  const std::int32_t n = size(b);
  extract(jacobian, b, lane, matrix_);
  norms.omega[lane] = norms.scale[lane] = kInfinity;
  if (!invert_matrix(n)) return;
  const auto rows = equations(b);
  for (std::vector<double>* v : {&of_lipschitz_, &of_scale_}) std::fill_n(v->begin(), n, 0.0);
  for (std::int32_t c = 0; c < n; ++c) {
    const std::int32_t at = rows[idx(c)] * lanes_ + lane;
    const double lipschitz = weights.lipschitz[at], of_scale = weights.scale[at];
    const double* const column = inverse_.data() + idx(c * n);
    for (std::size_t r = 0; r < idx(n); ++r) {
      of_lipschitz_[r] += std::abs(column[r]) * lipschitz;
      of_scale_[r] += std::abs(column[r]) * of_scale;
    }
  }
  norms.omega[lane] = largest_of(of_lipschitz_, idx(n));
  norms.scale[lane] = largest_of(of_scale_, idx(n));
}

bool BlockConditions::invert(std::int32_t b, const BoxTest::Lane& of) {
  if (is_large(b)) return false;
  extract(of.jacobian, b, of.lane, matrix_);
  return invert_matrix(size(b));
}

bool BlockConditions::hold(std::int32_t b, const BoxTest::Lane& of) {
  return boxes_->hold(of, {entries(b), unknowns(b), equations(b)}, inverse_.data());
}

bool BlockConditions::hold_one_solution(std::int32_t b, const BoxTest::Lane& of, const double* unknowns,
                                        const double* inputs) {
  if (!invert(b, of)) return false;
  boxes_->take(of, unknowns, inputs);
  return hold(b, of);
}

bool BlockConditions::holds_one_solution(std::int32_t b, const BoxTest::Lane& of, const double* phi,
                                         const double* scale) {
  if (!invert(b, of)) return false;
  boxes_->take(of, phi, scale, class_.equations.size());
  return hold(b, of);
}

// Hager's power method for | J^-1 D |_inf = | (J^-1 D)^T |_1, all lanes at once. Right-hand sides are zero outside the
// block, so the solutions on the block are those of the block alone.
void BlockConditions::sparse_norms(std::int32_t b, const double* weights, LinearSolver& solver, double* norms) {
  const auto columns = unknowns(b), rows = equations(b);
  const std::int32_t n = size(b);
  const std::span<double> vector = std::span(vector_).first(idx(class_.n) * idx(lanes_));
  const auto at = [&](std::int32_t i, int w) -> double& { return vector[idx(i * lanes_ + w)]; };
  std::fill_n(norms, lanes_, 0.0);
  // Starts with the row of J^-1 D whose product with a vector of ones is largest.
  std::fill(vector.begin(), vector.end(), 0.0);
  for (int w = 0; w < lanes_; ++w) {
    for (const std::int32_t r : rows) at(r, w) = weights[r * lanes_ + w];
  }
  for (int round = 0; round < kHagerRounds; ++round) {
    if (!solver.solve(vector, 1).ok()) break;
    for (int w = 0; w < lanes_; ++w) {
      std::int32_t worst = columns[0];
      for (const std::int32_t c : columns) {
        if (!(std::abs(at(c, w)) <= std::abs(at(worst, w)))) worst = c;
      }
      for (std::int32_t i = 0; i < class_.n; ++i) at(i, w) = 0;
      at(worst, w) = 1;
    }
    if (!solver.solve(vector, 1, Transpose::yes).ok()) break;
    for (int w = 0; w < lanes_; ++w) {
      double sum = 0;
      for (std::int32_t k = 0; k < n; ++k) {
        const double z = at(rows[idx(k)], w) * weights[rows[idx(k)] * lanes_ + w];
        sum += std::abs(z);
      }
      norms[w] = std::isfinite(sum) ? std::max(norms[w], sum) : kInfinity;
      for (const std::int32_t r : rows) at(r, w) = std::copysign(weights[r * lanes_ + w], at(r, w));
      for (std::int32_t i = 0; i < class_.n; ++i) {
        if (class_.equation_block[idx(i)] != b) at(i, w) = 0;
      }
    }
  }
  for (int w = 0; w < lanes_; ++w) {
    if (norms[w] == 0) norms[w] = kInfinity;  // no solve succeeded
  }
}

}  // namespace assur
