// Members of an ensemble that are not prepared one by one: a table of values tells what they are, and they are bound to
// it in the lanes in which they run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "plan/preparation.hpp"
#include "runs/tile.hpp"

namespace assur {

// Binds members to the lanes of one tile.
class MemberBinder {
 public:
  virtual ~MemberBinder() = default;

  // Makes a variant of each member, with a guess of its posture; null where the member must be prepared instead. The
  // variants are valid until the next call.
  virtual void bind(std::span<const std::size_t> members, std::span<const Variant*> variants) = 0;

  // Assembles the posture of the i-th member of bind() as prepare() does, from its guess. False if that is not enough
  // to find it, so that the member must be prepared.
  [[nodiscard]] virtual bool assemble(std::size_t i) = 0;

  // True if the posture that was assembled from the one of a variant is the one that prepare() would find.
  [[nodiscard]] virtual bool is_start(const Variant& guess, std::span<const double> posture) const = 0;
};

// The members. Several threads may use the const functions at once.
class BoundMembers {
 public:
  virtual ~BoundMembers() = default;

  [[nodiscard]] virtual std::size_t count() const = 0;
  // A member that can be prepared, or the scene as written: all members are bound to its structure and plan. Null if
  // nothing can be assembled.
  [[nodiscard]] virtual const Preparation* first() const = 0;
  // Names of the outputs, and the time grid, of all members.
  [[nodiscard]] virtual std::vector<std::string> columns() const = 0;
  [[nodiscard]] virtual const TimeGrid& time() const = 0;
  // The reason why all members must be prepared one by one; "": members can be bound.
  [[nodiscard]] virtual const std::string& why_not() const = 0;
  // lanes: largest number of members at once.
  [[nodiscard]] virtual std::unique_ptr<MemberBinder> binder(std::size_t lanes) const = 0;
  // Throws Error like assur::prepare().
  [[nodiscard]] virtual Preparation prepare(std::size_t member) const = 0;
  // Replaces the members. False: the binders serve them, too. Throws Error (input) if the values do not make whole
  // rows.
  virtual bool take(std::vector<double> values) = 0;
};

}  // namespace assur
