// Samples of a design space, block by block: the members of an Ensemble, of which only figures are kept.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "assur/curve.hpp"
#include "assur/ensemble.hpp"
#include "sweep/design_space.hpp"

namespace assur::sweep {

// One sample.
struct DesignSample {
  std::int64_t sample = 0;
  std::vector<double> parameters;
  std::string status;           // name of a Code, or "not_assembled"
  double reached = 0;           // last time with a valid posture, s; NaN if it was not assembled
  std::vector<double> figures;  // NaN if it was not assembled
  std::string why;              // reason why it was not assembled; a file does not have it

  [[nodiscard]] bool is_assembled() const { return status != kNotAssembled; }
  [[nodiscard]] bool is_done() const { return status == "ok" || status == "inaccurate"; }

  static constexpr const char* kNotAssembled = "not_assembled";
};

// The columns that a sweep of this scene keeps: its outputs. Throws like group_equations().
[[nodiscard]] std::vector<std::string> columns_of(const Scene& scene);

// The names of figures: min, max, min_time, max_time, mean, last, range.
[[nodiscard]] const std::vector<std::string>& figure_names();

// The names of distances between curves: nearest, timed, fitted, shape.
[[nodiscard]] const std::vector<std::string>& distance_names();

// The path of a point, and the curve that it is compared with. The first figure is the distance, see assur/curve.hpp;
// NaN if the motion ended early, so that it has fewer points.
struct Trace {
  std::string point;
  std::vector<PlanePoint> target;
  std::string distance;  // one of distance_names()
};

// Throws Error (input) at "--trace" unless this is a point in the plane among the outputs of the scene, `columns`.
void check_point(const std::string& point, const Scene& scene, const std::vector<std::string>& columns);

// Throws Error (input) at "--compare" unless the path can be compared with the curve in this way.
void check_target(const Trace& trace, const Scene& scene);

// Throws Error (input) at "--vary" if two samples have different times.
void check_same_times(const Scene& one, const Scene& other);

class Sweep {
 public:
  // Samples in a block. Blocks begin at multiples of it, wherever a range begins: the members of a pack, and with them
  // the last bits of a row, are the same for every range.
  static constexpr std::int64_t kBlock = 1024;

  // scene: has the parameters of the space. columns, figures: what is kept. trace: empty, or of a point whose
  // coordinates are outputs.
  Sweep(const DesignSpace& space, Scene scene, PrepareOptions how, std::vector<std::string> columns,
        std::vector<std::string> figures, std::optional<Trace> trace, StepSettings settings);

  // The samples from b * kBlock on. Empty if settings.stop asked to stop. Throws as Ensemble, but not for samples that
  // cannot be prepared.
  [[nodiscard]] std::vector<DesignSample> block(std::int64_t b);

  // The names of DesignSample::figures: "P.distance", "limits" (if the scene has limits: how often one was exceeded, or
  // ended the motion), "handle1.max", ...
  [[nodiscard]] std::vector<std::string> figures() const;

  // The first line of a file of rows, and the line of a row; without line ends. Numbers are the shortest text that
  // reads back as the same double; NaN is empty.
  [[nodiscard]] std::string header() const;
  [[nodiscard]] static std::string line_of(const DesignSample& row);
  // Reads a line back. Throws Error (input) if it is not the line of a row of this sweep.
  [[nodiscard]] DesignSample parse(const std::string& line) const;

 private:
  [[nodiscard]] Ensemble make(std::vector<double> values) const;
  [[nodiscard]] std::vector<double> values_of(std::int64_t b) const;
  void run(Ensemble& ensemble, std::vector<DesignSample>& rows);
  [[nodiscard]] double distance(std::span<const PlanePoint> path) const;

  const DesignSpace& space_;
  Scene scene_;
  PrepareOptions how_;
  std::vector<std::string> columns_, figures_;
  std::optional<Trace> trace_;
  StepSettings settings_;
  // Made with the first block, whatever range is asked for, so that a row does not depend on the range. Empty: none of
  // its samples can be prepared, so that each block makes its own.
  std::optional<Ensemble> ensemble_;
  bool is_made_ = false;
};

}  // namespace assur::sweep
