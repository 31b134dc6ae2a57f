#include "plan/preparation.hpp"
#include "scene/time_grid.hpp"

namespace assur {

Strategy Plan::strategy(const Choice& choice) const {
  Strategy all{run, choice.solver};
  all.run.threads = choice.threads;
  return all;
}

const std::string& Prepared::name() const { return parts_->name; }
const Scene* Prepared::scene() const { return parts_->scene.get(); }
const TimeGrid& Prepared::time() const { return parts_->time; }
Structure Prepared::structure() const { return Structure(parts_->structure); }
const Plan& Prepared::plan() const { return parts_->plan; }
const std::vector<std::string>& Prepared::controlled() const { return parts_->controlled; }

Prepared Prepared::with_time(const TimeGrid& time) const {
  std::vector<Diagnostic> wrong = wrong_grid(time);
  if (time.start != parts_->time.start) wrong.push_back({"/time/start", "the start posture is that of another time"});
  if (!wrong.empty()) throw Error(Error::Kind::input, std::move(wrong));
  Preparation other = *parts_;
  other.time = time;
  return Preparation::shared(std::move(other));
}

}  // namespace assur
