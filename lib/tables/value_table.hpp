// Members of an ensemble as rows of a table: a scene with other values of its parameters.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "assur/scene.hpp"
#include "plan/preparation.hpp"
#include "plan/prepare_at.hpp"
#include "runs/bound_members.hpp"
#include "start/walk.hpp"
#include "structure/grouped_system.hpp"
#include "tables/recipe.hpp"
#include "tables/replay.hpp"

namespace assur {

class ValueTable final : public BoundMembers {
 public:
  // As the constructor of Ensemble.
  ValueTable(const Scene& scene, std::vector<std::string> names, std::vector<double> values,
             const PrepareOptions& options, AtRest at_rest);

  [[nodiscard]] std::size_t count() const override { return values_.size() / names_.size(); }
  [[nodiscard]] const Preparation* first() const override { return first_ ? &*first_ : nullptr; }
  [[nodiscard]] std::vector<std::string> columns() const override;
  [[nodiscard]] const TimeGrid& time() const override { return first_ ? first_->time : scene_.time(); }
  [[nodiscard]] const std::string& why_not() const override { return why_not_; }
  [[nodiscard]] std::unique_ptr<MemberBinder> binder(std::size_t lanes) const override;
  [[nodiscard]] Preparation prepare(std::size_t member) const override { return prepare(scene_at(member)); }
  bool take(std::vector<double> values) override;

 private:
  class Binder;
  [[nodiscard]] std::span<const double> row(std::size_t member) const {
    return std::span(values_).subspan(member * names_.size(), names_.size());
  }
  void check_size(std::size_t values) const;
  // tape: null, or what varies are its parameters.
  [[nodiscard]] Scene scene_at(std::size_t member, ParameterTape* tape = nullptr) const;
  [[nodiscard]] KnownStart known_start() const;
  [[nodiscard]] Preparation prepare(const Scene& scene) const;
  [[nodiscard]] bool has_constants(std::size_t member) const;
  void prepare_first();
  void record_assembly(const Scene& scene, const Tape& tape);
  void record();
  [[nodiscard]] bool record_at(std::size_t member);

  Scene scene_;
  std::vector<std::string> names_;
  std::vector<double> values_;  // members x names
  PrepareOptions options_;
  AtRest at_rest_;
  std::optional<Preparation> first_;
  std::size_t first_member_ = 0;  // that of first_; 0 if it is the scene as written
  std::string why_not_;
  bool depends_on_values_ = false;  // why_not_ does: other members may be bound
  // The recorded computation.
  std::vector<std::size_t> varying_;         // columns that are its parameters
  std::vector<double> recorded_;             // a row: the other columns must have these values
  std::optional<ParameterProgram> program_;  // of the numbers of recipe_, then of those of assembly_
  std::optional<Recipe> recipe_;
  std::shared_ptr<const GroupedSystem> structure_;  // of the recorded mechanism
  // Its equations before presolve, which prepare() assembles block after block. Empty: they are not enough for that.
  struct Assembly {
    System system;
    std::vector<WalkedPart> parts;
    Recipe recipe;
  };
  std::optional<Assembly> assembly_;
};

}  // namespace assur
