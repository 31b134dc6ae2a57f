// The strategy +together: one step of the groups of all levels at once. The groups are linearised at the prediction and
// factorised side by side, independent of their levels; only a linear recurrence over their couplings runs through the
// levels (program/together_step.hpp). This is Newton's method for the whole block triangular system. A step passes the
// tests of single groups: residuals, first correction, ball and anchor of every group. Larger groups use the pivots
// that suit the groups of their class at the start posture.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "assur/report.hpp"
#include "backends/lanes_elimination.hpp"
#include "executors/step_code.hpp"
#include "groups/attempt.hpp"
#include "groups/coupling.hpp"
#include "motion/layout.hpp"
#include "parallel/team.hpp"
#include "plan/preparation.hpp"
#include "program/group_step.hpp"
#include "program/together_step.hpp"

namespace assur {

// The groups of a layout with one lane, side by side in their classes.
class Together {
 public:
  // All must outlive it. The plan must have RunSettings::together. team: its threads share the groups; null: one thread
  Together(const Preparation& prepared, Layout& layout, Team* team);

  // The most threads that have work.
  [[nodiscard]] static std::size_t shares(const GroupedSystem& structure);

  // Takes machine code for the passes, if there is some, with the same bits.
  void use(StepCode& code) { code_ = &code; }
  // To be called when the packs of the layout have solved a start posture: chooses pivots, makes the passes, and takes
  // the memory that solve() needs.
  void start(double* const (&state)[3]);
  [[nodiscard]] std::size_t coded_groups() const;

  // Makes an attempt inside the branch, like Levels::solve(). False if a test fails or pivots are too small; the
  // state then holds the prediction again, and the packs of the layout are unchanged.
  [[nodiscard]] bool solve(double* const (&state)[3], const Attempt& attempt, Counters& counters, StepErrors& errors);

  // Restores the balls used (Pack::ball_used) to their state before an attempt, as Pack::undo() does for single packs.
  void undo(std::int64_t attempt);
  // To be called when the packs of the layout were changed by others.
  void forget() { up_to_date_ = false; }

 private:
  // A load of a group and the loads that it depends on.
  struct LoadLinks {
    std::int32_t at;          // index into loads_
    std::int32_t begin, end;  // links
    std::int32_t chain = 1;   // number of rows from here on that depend only on the row before them, with consecutive
                              // loads and gains
  };
  struct Link {
    std::int32_t gain, load;  // indices into gains_ and loads_
  };
  struct Copy {
    std::int32_t to, from;  // loads
  };
  // The group that computes a coordinate: its class and its place among the groups of the class. -1: none
  struct Source {
    std::int32_t of_class = -1, place = -1, unknown = -1;
  };
  // A row depends on a row of the group that a part of its entries reads.
  struct Gain {
    std::int32_t row, of;     // coupled rows of this group and of the other one
    std::int32_t begin, end;  // entries
  };
  // The groups of a class that a thread works on.
  struct Share {
    std::size_t first = 0, lanes = 0;  // places
    std::vector<Run> known;            // from the state to inputs that move, and that no group computes
    InputSources sources;              // in arrays of unknowns
    std::array<std::shared_ptr<const Executor>, kTogetherPasses> passes;
    std::array<double*, kMemories> memory{};

    void run(TogetherPass pass) { passes[static_cast<std::size_t>(pass)]->run(memory); }
  };
  // Numbers of groups by [number][place]; idle places repeat the first group.
  struct Class {
    GroupSolver* solver;  // of the class in the layout
    std::int32_t derivatives;
    std::vector<std::int32_t> groups;         // in solving order
    std::size_t places;                       // with idle ones
    std::size_t unknowns, loads, first_gain;  // where those of the class begin
    Couplings couplings;
    lanes::Elimination elimination;  // of more than kWithoutPivots unknowns
    bool has_pivots = false, has_passes = false, is_coded = false;
    std::vector<Gain> gains;
    LaneArray coefficients, lipschitz, anchor, anchor_rates, anchor_time, omega, balls_used, work, figures,
        of_couplings;
    std::array<LaneArray, 3> inputs;  // [d]: d-th derivatives
    LaneArray known_rates;            // input rates without those that groups compute
    LaneArray sources;                // changes of inputs
    LaneArray balls_used_before;      // before the attempt `balls_of_`
    std::vector<Share> shares;        // threads
  };

  void make_classes();
  void sort_entries(Class& c);
  void divide();
  [[nodiscard]] TogetherClass outline(const Class& c) const;
  void fill(Class& c, Share& share);
  void choose_pivots(Class& c, const double* state);
  void make_passes(Class& c);
  void find_sources(const Class& c, Share& share) const;
  void make_rows();
  void add_row(const LoadLinks& row);
  [[nodiscard]] const SolvedGroup& group(const Class& c, std::size_t place) const;
  [[nodiscard]] Pack& pack(const Class& c, std::size_t place) const;
  [[nodiscard]] std::int32_t address(const Source& source) const;
  [[nodiscard]] Source source(const Class& c, std::size_t place, std::int32_t input) const;

  void take(const double* state);
  template <class Work>
  void each_of_guard(Class& c, Pack& of, const Work& work);
  void take_guard(Class& c, std::size_t place);
  void give_guard(Class& c, std::size_t place);
  template <class... Works>
  void pass(const Works&... works);
  void read(Class& c, const Share& share, double* const (&state)[3]);
  void couple(const Class& c, const Share& share, const LaneArray& changes, bool with_gains);
  void complete(const Class& c, const Share& share, LaneArray& to);
  void complete_loads();
  [[nodiscard]] double largest(GroupFigure f) const;
  [[nodiscard]] bool converge(double* const (&state)[3], const Attempt& attempt, int& corrections);
  void derive();
  void write(double* const (&state)[3]);
  [[nodiscard]] bool keep_on_branch(double* const (&state)[3], const Attempt& attempt, Counters& counters);
  void renew_anchors(Class& c, std::size_t eight);
  void count(int corrections, Counters& counters) const;

  const GroupedSystem& structure_;
  Layout& layout_;
  std::vector<std::int32_t> pack_of_;  // group -> pack of the layout
  Team* team_;
  StepCode* code_ = nullptr;
  std::size_t threads_;
  const CouplingKernels& kernels_;
  std::vector<Source> sources_;  // source of each coordinate
  std::vector<Class> classes_;
  // Numbers of all classes, by class [unknown][place]: an unknown has the same address in each array.
  LaneArray own_, change_;                           // changes of the unknowns: alone, and with all loads
  std::array<LaneArray, kMostCoupledRows> columns_;  // change of the unknowns for a load of 1, by coupled row
  std::array<LaneArray, 3> unknowns_;                // [d]: d-th derivatives
  LaneArray loads_;                                  // of the coupled rows, by class [row][place]
  LaneArray gains_;                                  // by class [gain][place]
  std::vector<LoadLinks> rows_;                      // in solving order
  std::vector<Link> links_;
  std::vector<Copy> idle_;  // loads that idle places copy
  int derivatives_ = 0;     // highest derivative of all classes
  std::array<double, kGroupSettings> settings_{};
  LaneArray prediction_;
  bool up_to_date_ = false;    // the guards of the classes are those of the layout
  std::int64_t balls_of_ = 0;  // the last attempt that changed the balls used of all groups
};

}  // namespace assur
