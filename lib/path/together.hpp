// The strategy +together: one step of the groups of all levels at once. The groups are linearised at the prediction and
// factorised side by side, whatever their levels, and only a linear recurrence over their couplings runs through the
// levels (group/together_step.hpp). This is Newton's method for the whole block triangular system. The tests of a step
// are those of single groups: residuals, the first correction and the ball of every group, and its anchor.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "assur/plan.hpp"
#include "assur/report.hpp"
#include "group/attempt.hpp"
#include "group/together_step.hpp"
#include "parallel/team.hpp"
#include "path/layout.hpp"

namespace assur {

// Packs of several lanes for the groups of a layout with one lane, class by class.
class Together {
 public:
  // All must outlive it. The plan must have RunSettings::together. team: its threads share the packs; null: one thread
  Together(const Prepared& prepared, Layout& layout, Team* team);

  // Number of packs of several lanes.
  [[nodiscard]] static std::size_t packs(const Prepared& prepared);

  // Makes an attempt inside the branch, like Levels::solve(). False: something is unusual; the state then holds the
  // prediction again, and the packs of the layout are unchanged.
  [[nodiscard]] bool solve(double* const (&state)[3], const Attempt& attempt, Counters& counters, StepErrors& errors);

  // Restores the balls used (Pack::ball_used) to their state before an attempt, as Pack::undo() does for single packs.
  void undo(std::int64_t attempt);
  // To be called when the packs of the layout were changed by others.
  void forget() { up_to_date_ = false; }
  // After the start posture was solved: takes the memory that solve() needs.
  void reserve(const double* state) {
    take(state);
    forget();
  }

 private:
  // A load of a group and the loads that it depends on.
  struct Row {
    std::int32_t at;          // index into Coupling::loads
    std::int32_t begin, end;  // links
    std::int32_t chain = 1;   // number of rows from here on that depend only on the row before them, with consecutive
                              // loads and gains
  };
  struct Link {
    std::int32_t gain, load;  // indices into Coupling::gains and loads
  };
  struct Copy {
    std::int32_t to, from;  // loads
  };
  struct Class {
    std::vector<std::unique_ptr<TogetherStep>> steps;  // threads: each has a part of the packs
    GroupSolver* solver;                               // solver of the class in the layout
    std::int32_t lanes, derivatives;
    std::vector<std::int32_t> groups;  // in solving order
    TogetherStep::Places places;
    LaneArray balls_used, balls_used_before;  // Pack::ball_used by place, now and before the attempt `balls_of_`

    [[nodiscard]] TogetherStep& step() const { return *steps[0]; }
  };
  struct alignas(64) Share {  // of a thread in one pass
    TogetherFigures figures;
    TogetherStep::Progress progress;
  };
  // The group that computes a coordinate: its class and its place among the groups of the class. -1: none
  struct Source {
    std::int32_t of_class = -1, place = -1, unknown = -1;
  };

  void make_steps(const Prepared& prepared);
  void fill_packs(Class& c, std::size_t& pack_number, std::size_t packs);
  void find_parts(Class& c);
  void make_rows();
  void add_row(const Row& row);
  [[nodiscard]] std::int32_t address(const Source& source) const;
  [[nodiscard]] Source source(const Class& c, std::int32_t group, std::size_t entry) const;

  void take(const double* state);
  void take_lane(TogetherPack& to, std::size_t lane, std::size_t lanes);
  template <class... Works>
  void pass(const Works&... works);
  void complete_loads();
  [[nodiscard]] bool converge(double* const (&state)[3], const Attempt& attempt, int& iterations,
                              TogetherFigures& figures);
  void derive(double* const (&state)[3], TogetherFigures& figures);
  [[nodiscard]] bool keep_on_branch(double* const (&state)[3], const Attempt& attempt, Counters& counters);
  void count(int iterations, Counters& counters) const;

  const Structure& structure_;
  Layout& layout_;
  std::vector<std::int32_t> pack_of_;  // group -> pack of the layout
  Team* team_;
  std::vector<Share> shares_;  // threads
  ChainOfLoads chain_;
  std::vector<Source> sources_;  // source of each coordinate
  std::vector<Class> classes_;
  Coupling coupling_;
  std::vector<Row> rows_;  // in solving order
  std::vector<Link> links_;
  std::vector<Copy> idle_;  // loads that idle lanes copy
  int derivatives_ = 0;     // highest derivative of all classes
  LaneArray prediction_;
  bool up_to_date_ = false;    // the guards in the packs are those of the layout
  std::int64_t balls_of_ = 0;  // the last attempt that changed the balls used of all groups
};

}  // namespace assur
