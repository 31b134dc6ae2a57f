#include "motion/independence.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

#include "decompositions.hpp"
#include "equations/dense_block.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "start/independent_rows.hpp"

namespace assur {
namespace {

constexpr std::size_t kLargestDense = 200;  // unknowns of a dense matrix; a choice: it is factored during motions

}  // namespace

struct Independence::Unit {
  std::vector<Index> unknowns;
  std::vector<Gradient> rows;
  Eigen::MatrixXd jacobian;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu;
  Eigen::VectorXd right;
};

Independence::~Independence() = default;

Independence::Independence(const System& system, const GroupedSystem& structure, std::span<const std::int32_t> address)
    : system_(system),
      address_(address),
      unit_of_(system.coordinates.size(), -1),
      place_(system.coordinates.size(), -1),
      q_(structure.start),
      gradient_(system.coordinates.size(), 0.0),
      seen_(system.coordinates.size(), 0) {
  collect(structure);
  const auto too_large = [](const Unit& u) { return u.unknowns.size() > kLargestDense; };
  if (!in_solving_order() || std::any_of(units_.begin(), units_.end(), too_large)) {
    units_.clear();
    dropped_.clear();
  }
  reserve();
  std::size_t arguments = 0, slopes = 0;
  for (const CallbackBlock& b : system_.callbacks) {
    arguments = std::max(arguments, b.coordinates.size());
    slopes = std::max(slopes, b.coordinates.size() * idx(b.callback->equations));
  }
  arguments_.resize(arguments);
  slopes_.resize(slopes);
}

// Collects the blocks of the groups, level after level, that the watched equations depend on.
void Independence::collect(const GroupedSystem& structure) {
  std::vector<std::size_t> order(structure.groups.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return structure.groups[a].level < structure.groups[b].level; });
  for (const std::size_t g : order) {
    const SolvedGroup& group = structure.groups[g];
    const GroupClass& c = structure.classes[idx(group.group_class)];
    std::vector<Unit> blocks(idx(c.blocks));
    for (std::size_t i = 0; i < group.unknowns.size(); ++i) {
      blocks[idx(c.unknown_block[i])].unknowns.push_back(group.unknowns[i]);
    }
    for (std::size_t i = 0; i < group.equations.size(); ++i) {
      blocks[idx(c.equation_block[i])].rows.push_back({group.equations[i]});
    }
    std::move(blocks.begin(), blocks.end(), std::back_inserter(units_));
  }
  for (const std::int32_t e : structure.watch.equations) dropped_.push_back({e});
  keep_those_behind();
  for (std::size_t u = 0; u < units_.size(); ++u) {
    Unit& unit = units_[u];
    for (std::size_t i = 0; i < unit.unknowns.size(); ++i) {
      unit_of_[idx(unit.unknowns[i])] = static_cast<Index>(u);
      place_[idx(unit.unknowns[i])] = static_cast<Index>(i);
    }
  }
}

void Independence::reserve() {
  for (Unit& unit : units_) {
    const auto n = static_cast<Eigen::Index>(unit.unknowns.size());
    unit.jacobian.resize(n, n);
    unit.right.resize(n);
    unit.lu = Eigen::PartialPivLU<Eigen::MatrixXd>(n);
    for (Gradient& row : unit.rows) prepare(row);
  }
  for (Gradient& row : dropped_) prepare(row);
}

void Independence::prepare(Gradient& row) const {
  if (system_.equations[idx(row.equation)].callback < 0) return find_slopes(row);
  std::vector<Index> mentioned;
  system_.mentioned(row.equation, mentioned);
  row.entries.reserve(mentioned.size());
}

void Independence::find_slopes(Gradient& row) const {
  struct Slope {
    Index entry, coordinate;
    double value;
  };
  std::vector<Slope> slopes;
  const auto constant = [&](Index c) { return system_.constants[idx(c)]; };
  const auto add = [&](Index entry, Index coordinate, double value) {
    if (entry != kOne) slopes.push_back({entry, coordinate, value});
  };
  const Equation& e = system_.equations[idx(row.equation)];
  if (e.linear >= 0) {
    for (const Term& t : system_.form(e.linear)) add(t.coordinate, kOne, constant(t.constant));
  }
  for (const Product& p : system_.products_of(e)) {
    for (const Term& a : system_.form(p.a)) {
      for (const Term& b : system_.form(p.b)) {
        const double factor = constant(p.constant) * constant(a.constant) * constant(b.constant);
        add(a.coordinate, b.coordinate, factor);
        add(b.coordinate, a.coordinate, factor);
      }
    }
  }
  const auto key = [](const Slope& s) { return std::pair(s.entry, s.coordinate); };
  std::stable_sort(slopes.begin(), slopes.end(), [&](const Slope& a, const Slope& b) { return key(a) < key(b); });
  row.slopes.reserve(slopes.size());
  const Slope* last = nullptr;
  for (const Slope& s : slopes) {
    if (last != nullptr && key(*last) == key(s)) {
      row.slopes.back().value += s.value;
      continue;
    }
    if (last == nullptr || last->entry != s.entry) {
      row.entries.push_back({s.entry, 0});
      row.ends.push_back(0);
    }
    row.slopes.push_back({s.coordinate, s.value});
    row.ends.back() = static_cast<std::uint32_t>(row.slopes.size());
    last = &s;
  }
}

void Independence::keep_those_behind() {
  std::vector<std::uint8_t> needed(system_.coordinates.size(), 0);
  std::vector<Index> mentioned;
  const auto need = [&](const Gradient& row) {
    system_.mentioned(row.equation, mentioned);
    for (const Index c : mentioned) needed[idx(c)] = 1;
  };
  for (const Gradient& row : dropped_) need(row);
  for (auto unit = units_.rbegin(); unit != units_.rend(); ++unit) {
    const bool wanted =
        std::any_of(unit->unknowns.begin(), unit->unknowns.end(), [&](Index c) { return needed[idx(c)] != 0; });
    if (!wanted) {
      unit->rows.clear();
    } else {
      for (const Gradient& row : unit->rows) need(row);
    }
  }
  std::erase_if(units_, [](const Unit& u) { return u.rows.empty(); });
}

bool Independence::in_solving_order() {
  std::vector<Index> mentioned;
  for (std::size_t u = 0; u < units_.size(); ++u) {
    if (units_[u].rows.size() != units_[u].unknowns.size()) return false;
    for (const Gradient& row : units_[u].rows) {
      system_.mentioned(row.equation, mentioned);
      for (const Index c : mentioned) {
        if (unit_of_[idx(c)] > static_cast<Index>(u)) return false;
      }
    }
  }
  return true;
}

double Independence::largest_coefficient(const double* q) {
  for (std::size_t c = 0; c < q_.size(); ++c) {
    if (address_[c] >= 0) q_[c] = q[address_[c]];
  }
  for (Unit& unit : units_) {
    if (!factorize(unit)) return kInfinity;
  }
  double largest = 0;
  for (Gradient& row : dropped_) {
    const double of_row = largest_of(row);
    if (!(of_row <= largest)) largest = of_row;
  }
  return largest;
}

std::vector<Index> Independence::chosen_anew(std::span<const double> coordinates) {
  std::copy(coordinates.begin(), coordinates.end(), q_.begin());
  std::vector<Gradient*> rows;
  std::vector<Eigen::Index> first_column;  // units
  Eigen::Index columns = 0;
  for (Unit& unit : units_) {
    for (Gradient& row : unit.rows) rows.push_back(&row);
    first_column.push_back(columns);
    columns += static_cast<Eigen::Index>(unit.unknowns.size());
  }
  if (static_cast<std::size_t>(columns) > kLargestDense) return {};
  for (Gradient& row : dropped_) rows.push_back(&row);
  std::sort(rows.begin(), rows.end(), [](const Gradient* a, const Gradient* b) { return a->equation < b->equation; });
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows.size()), columns);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    differentiate(*rows[r]);
    for (const Coefficient& e : rows[r]->entries) {
      const Index unit = unit_of_[idx(e.coordinate)];
      if (unit < 0) continue;
      jacobian(static_cast<Eigen::Index>(r), first_column[idx(unit)] + place_[idx(e.coordinate)]) = e.value;
    }
  }
  const Eigen::MatrixXd scaled = scaled_rows(std::move(jacobian));
  const RowQr qr = factored(scaled.transpose());
  if (qr.rank() != columns) return {};
  std::vector<Index> out;
  const std::vector<Eigen::Index> order = independent_first(scaled, qr, columns);
  for (std::size_t k = static_cast<std::size_t>(columns); k < order.size(); ++k) {
    out.push_back(rows[static_cast<std::size_t>(order[k])]->equation);
  }
  return out;
}

void Independence::differentiate(Gradient& row) {
  if (system_.equations[idx(row.equation)].callback >= 0) differentiate_callback(row);
  std::uint32_t k = 0;
  for (std::size_t i = 0; i < row.ends.size(); ++i) {
    double sum = 0;
    for (; k < row.ends[i]; ++k) sum += row.slopes[k].value * q_[idx(row.slopes[k].coordinate)];
    row.entries[i].value = sum;
  }
  double squares = 0;
  for (const Coefficient& entry : row.entries) {
    if (unit_of_[idx(entry.coordinate)] >= 0) squares += entry.value * entry.value;
  }
  row.length = std::max(std::sqrt(squares), kLeastScale);  // a row that vanishes determines nothing
}

void Independence::differentiate_callback(Gradient& row) {
  row.entries.clear();
  const Equation& e = system_.equations[idx(row.equation)];
  const CallbackBlock& block = system_.callbacks[idx(e.callback)];
  const std::size_t m = block.coordinates.size();
  for (std::size_t i = 0; i < m; ++i) {
    arguments_[i] = form_value<double>(system_, block.coordinates[i], q_) * block.unit[i];
  }
  block.callback->jacobian({arguments_.data(), m}, {slopes_.data(), m * idx(block.callback->equations)});
  for (std::size_t i = 0; i < m; ++i) {
    const double slope = slopes_[idx(e.row) * m + i] * block.unit[i];
    for (const Term& t : system_.form(block.coordinates[i])) {
      if (t.coordinate == kOne) continue;
      if (seen_[idx(t.coordinate)] == 0) row.entries.push_back({t.coordinate, 0});
      seen_[idx(t.coordinate)] = 1;
      gradient_[idx(t.coordinate)] += system_.constants[idx(t.constant)] * slope;
    }
  }
  for (Coefficient& entry : row.entries) {
    entry.value = std::exchange(gradient_[idx(entry.coordinate)], 0.0);
    seen_[idx(entry.coordinate)] = 0;
  }
}

bool Independence::factorize(Unit& unit) {
  unit.jacobian.setZero();
  const Index self = unit_of_[idx(unit.unknowns.front())];
  for (std::size_t i = 0; i < unit.rows.size(); ++i) {
    differentiate(unit.rows[i]);
    for (const Coefficient& e : unit.rows[i].entries) {
      if (unit_of_[idx(e.coordinate)] != self) continue;
      unit.jacobian(static_cast<Eigen::Index>(i), place_[idx(e.coordinate)]) = e.value;
    }
  }
  unit.lu.compute(unit.jacobian);
  for (Eigen::Index i = 0; i < unit.jacobian.rows(); ++i) {
    const double pivot = unit.lu.matrixLU()(i, i);
    if (!std::isfinite(pivot) || pivot == 0) return false;
  }
  return true;
}

// Solves sum c_i grad Phi_i = grad of the row, from the last unit to the first.
double Independence::largest_of(Gradient& row) {
  differentiate(row);
  for (const Coefficient& e : row.entries) gradient_[idx(e.coordinate)] = e.value;
  double largest = 0;
  for (auto unit = units_.rbegin(); unit != units_.rend(); ++unit) {
    for (std::size_t j = 0; j < unit->unknowns.size(); ++j) {
      unit->right[static_cast<Eigen::Index>(j)] = gradient_[idx(unit->unknowns[j])];
    }
    // P J = L U, so U' L' P c = right.
    unit->lu.matrixLU().triangularView<Eigen::Upper>().transpose().solveInPlace(unit->right);
    unit->lu.matrixLU().triangularView<Eigen::UnitLower>().transpose().solveInPlace(unit->right);
    const auto& place = unit->lu.permutationP().indices();
    for (std::size_t i = 0; i < unit->rows.size(); ++i) {
      const Gradient& solved = unit->rows[i];
      const double c = unit->right[place[static_cast<Eigen::Index>(i)]];
      const double share = std::abs(c) * solved.length / row.length;
      if (!(share <= largest)) largest = share;
      for (const Coefficient& e : solved.entries) gradient_[idx(e.coordinate)] -= c * e.value;
    }
  }
  std::fill(gradient_.begin(), gradient_.end(), 0.0);
  return largest;
}

}  // namespace assur
