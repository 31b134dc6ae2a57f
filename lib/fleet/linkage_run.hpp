// The motion of one linkage over its times.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "assur/fleet.hpp"
#include "fleet/linkage.hpp"
#include "fleet/linkage_kernels.hpp"

namespace assur {

// Runs linkages, one after another; keeps its memory.
class LinkageRun {
 public:
  LinkageRun();

  // The result is valid until the next call. options.threads has no effect.
  const LinkageMotion& run(const PreparedLinkage& linkage, std::span<const double> times, const FleetOptions& options);

  [[nodiscard]] std::int64_t divided() const { return divided_; }  // intervals, of all runs

 private:
  // Eight times, and all joints at them.
  struct Block {
    std::array<double, kTimes> times{}, steps{};
    std::vector<JointBlock, LineAllocator<JointBlock>> joints;
    BlockFigures figures;
    unsigned doubtful = 0;
  };

  [[nodiscard]] Block& block(std::size_t level);
  void set_before(Block& block, const Block& from, int i) const;
  void evaluate(Block& block, double start);
  [[nodiscard]] bool pass(std::size_t level);
  [[nodiscard]] bool pass_interval(std::size_t level, unsigned i);
  void go_on_from(std::size_t level, unsigned i);
  void follow_to_limit(std::size_t level, unsigned i);
  [[nodiscard]] std::int32_t folded_triad(const Block& block, unsigned i) const;
  void begin_triads(Block& block);
  void end(Code code, double reached, double not_beyond, std::int32_t joint);
  void cannot_begin(const Block& block);
  void write_row(const Block& block, unsigned i);
  void check_error(double accuracy);

  const PreparedLinkage* linkage_ = nullptr;
  std::vector<Block> blocks_;  // of the run, and of intervals within intervals
  std::vector<PlanePoint> path_;
  std::size_t rows_ = 0;  // that the path has if the motion does not end
  LinkageMotion motion_;
  double error_ = 0, largest_ = 0;  // of the traced joint, m
  double tolerance_ = 0;            // of the time of a limit, s
  std::int64_t divided_ = 0;
};

}  // namespace assur
