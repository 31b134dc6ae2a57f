#include "assur/plan.hpp"

namespace assur {

Strategy Plan::strategy(const Choice& choice) const {
  Strategy all{run, choice.solver};
  all.run.threads = choice.threads;
  return all;
}

}  // namespace assur
