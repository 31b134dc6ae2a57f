// Watched equations: redundant equations that are evaluated at every posture instead of solved.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "evaluation/evaluator.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

// The watched equations of a structure.
class Watch {
 public:
  // `address`: coordinates -> index into the state arrays.
  Watch(const System& system, const GroupedSystem& structure, std::span<const std::int32_t> address);

  [[nodiscard]] std::size_t equations() const { return phi_.size(); }

  // Largest relative residual at the posture q.
  [[nodiscard]] double residual(const double* q);
  // The equation with the largest residual, and its violation at q: |Phi| / |grad Phi|, internal units.
  [[nodiscard]] std::size_t worst() const { return worst_; }
  [[nodiscard]] double violation(const double* q);

 private:
  [[nodiscard]] double worst_ratio();

  const GroupClass& class_;
  std::unique_ptr<Evaluator> evaluator_;
  std::vector<double> coefficients_;
  std::vector<std::int32_t> addresses_;  // inputs
  std::vector<double> inputs_, phi_, scale_;
  std::size_t worst_ = 0;
};

}  // namespace assur
