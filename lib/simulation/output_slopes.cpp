#include "simulation/output_slopes.hpp"

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "decompositions.hpp"
#include "equations/outputs.hpp"
#include "index.hpp"
#include "numbers.hpp"

namespace assur {

struct OutputSlopes::Decomposition {
  Eigen::MatrixXd matrix;
  Eigen::JacobiSVD<Eigen::MatrixXd> svd;
};

OutputSlopes::~OutputSlopes() = default;

OutputSlopes::OutputSlopes(const GroupedSystem& structure, Continuation& motion, const OutputProgram& outputs)
    : motion_(motion), outputs_(outputs) {
  std::vector<std::string> columns;
  std::set<std::pair<std::string, std::size_t>> seen;  // components; rates that are asked for apart have no row
  for (const Output& o : wanted_outputs(*structure.system)) {
    const std::size_t first = columns.size();
    append_columns(o, columns);
    const auto derivative = static_cast<std::size_t>(std::find(o.wanted, o.wanted + 3, true) - o.wanted);
    for (std::size_t k = 0; k < o.part_count; ++k) {
      const std::size_t component = o.component < 0 ? k : static_cast<std::size_t>(o.component);
      if (!seen.emplace(o.name, component).second) continue;
      rows_.push_back({first + k, derivative});
      out_.outputs.push_back(columns[first + k]);
      asked_[derivative] = true;
    }
  }
  for (const Inputs::Control& c : motion.inputs().controls()) out_.drivers.push_back(c.name);
  const std::size_t drivers = out_.drivers.size(), size = motion.layout().size;
  for (LaneArray& v : known_) v.resize(size);
  resting_.resize(size);
  changes_.assign(drivers, LaneArray(size));
  for (LaneArray& v : changes_) pointers_.push_back(v.data());
  regular_.resize(motion.packs().size());
  slopes_.resize(columns.size());
  out_.values.resize(rows_.size() * drivers);
  if (!out_.values.empty()) {
    Eigen::MatrixXd matrix(static_cast<Eigen::Index>(rows_.size()), static_cast<Eigen::Index>(drivers));
    Eigen::JacobiSVD<Eigen::MatrixXd> svd(matrix.rows(), matrix.cols());
    decomposition_ = std::make_unique<Decomposition>(Decomposition{std::move(matrix), std::move(svd)});
  }
}

// Computes changes_, the derivatives of all coordinates.
Status OutputSlopes::follow_drivers() {
  double* const known[3] = {known_[0].data(), known_[1].data(), known_[2].data()};
  std::copy_n(motion_.at(0), known_[0].size(), known_[0].begin());
  if (const Status s = motion_.inputs().drive(motion_.time(), known); !s.ok()) return s;
  for (std::size_t i = 0; i < changes_.size(); ++i) {
    std::fill(known_[1].begin(), known_[1].end(), 0.0);
    motion_.inputs().differentiate(i, known);
    std::copy(known_[1].begin(), known_[1].end(), changes_[i].begin());
  }
  motion_.levels().each([&](std::size_t p, GroupSolver& solver) {
    const bool has_slopes =
        !motion_.layout().change_points[p].exists();  // no linear system gives them on a change point
    regular_[p] = has_slopes && solver.follow(motion_.packs()[p], motion_.at(0), pointers_) ? 1 : 0;
  });
  const auto singular = std::find(regular_.begin(), regular_.end(), 0);
  if (singular == regular_.end()) return {};
  const Pack& pack = motion_.packs()[static_cast<std::size_t>(singular - regular_.begin())];
  return {Code::singular, Place::group(pack.groups[0]), 0};
}

const OutputJacobian& OutputSlopes::compute() {
  out_.smallest_singular_value = kNan;
  out_.status = follow_drivers();
  if (!out_.status.ok()) {
    std::fill(out_.values.begin(), out_.values.end(), kNan);
    return out_;
  }
  const std::size_t drivers = changes_.size();
  const double* const state[3] = {motion_.at(0), motion_.at(1), motion_.at(2)};
  for (std::size_t i = 0; i < drivers; ++i) {
    for (std::size_t d = 0; d < 3; ++d) {
      if (!asked_[d]) continue;
      // The d-th derivative of an output changes by that of the coordinates as the output does by the coordinates.
      const double* change[3] = {resting_.data(), resting_.data(), resting_.data()};
      change[d] = changes_[i].data();
      outputs_.differentiate(state, {change[0], change[1], change[2]}, nullptr, slopes_.data());
      for (std::size_t r = 0; r < rows_.size(); ++r) {
        if (rows_[r].derivative == d) out_.values[r * drivers + i] = slopes_[rows_[r].column];
      }
    }
  }
  if (!decomposition_) return out_;
  auto& [matrix, svd] = *decomposition_;
  using ByRows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  matrix = Eigen::Map<const ByRows>(out_.values.data(), matrix.rows(), matrix.cols());
  if (!matrix.allFinite()) return out_;  // an output has no derivative here
  out_.smallest_singular_value = svd.compute(matrix).singularValues().minCoeff();
  return out_;
}

}  // namespace assur
