// SolveSpace's libslvs, a solver of geometric constraints: points and distances, all unknowns in one group, starting
// from the last posture. Positions only. libslvs is under the GPL-3, so this program contains no part of assur.
#include <cstring>

#include <slvs.h>

#include <cmath>
#include <stdexcept>
#include <utility>

#include "mechanisms.hpp"
#include "peer.hpp"

namespace peers {
namespace {

// libslvs ends at an absolute residual of 1e-8, which is 1e-12 m in this unit.
constexpr double kScale = 1e4;

class Sketch {
 public:
  enum Group : Slvs_hGroup { given = 1, sought = 2 };

  Slvs_hEntity point(Group group, const Vec& at) {
    const Slvs_hParam first = handle(params_);
    for (std::size_t k = 0; k < 3; ++k) params_.push_back(Slvs_MakeParam(handle(params_), group, kScale * at[k]));
    entities_.push_back(Slvs_MakePoint3d(handle(entities_), group, first, first + 1, first + 2));
    return entities_.back().h;
  }
  // A point of the plane z = 0.
  Slvs_hEntity planar_point(Group group, const Vec& at) {
    if (plane_ == 0) make_plane();
    const Slvs_hParam first = handle(params_);
    for (std::size_t k = 0; k < 2; ++k) params_.push_back(Slvs_MakeParam(handle(params_), group, kScale * at[k]));
    entities_.push_back(Slvs_MakePoint2d(handle(entities_), group, plane_, first, first + 1));
    return entities_.back().h;
  }
  void distance(Slvs_hEntity p, Slvs_hEntity q, double value) {
    constraints_.push_back(
        Slvs_MakeConstraint(handle(constraints_), sought, SLVS_C_PT_PT_DISTANCE, plane_, kScale * value, p, q, 0, 0));
  }
  void move(Slvs_hEntity point, const Vec& at) {
    const Slvs_Entity& e = entities_[point - 1];
    const std::size_t components = e.type == SLVS_E_POINT_IN_2D ? 2 : 3;
    for (std::size_t k = 0; k < components; ++k) params_[e.param[k] - 1].val = kScale * at[k];
  }
  void read(Slvs_hEntity point, std::size_t components, double* to) const {
    for (std::size_t k = 0; k < components; ++k) to[k] = params_[entities_[point - 1].param[k] - 1].val / kScale;
  }
  void solve() {
    Slvs_System system;
    std::memset(&system, 0, sizeof system);
    system.param = params_.data();
    system.params = static_cast<int>(params_.size());
    system.entity = entities_.data();
    system.entities = static_cast<int>(entities_.size());
    system.constraint = constraints_.data();
    system.constraints = static_cast<int>(constraints_.size());
    Slvs_Solve(&system, sought);
    if (system.result == SLVS_RESULT_TOO_MANY_UNKNOWNS) throw std::runtime_error("too many unknowns");
    if (system.result != SLVS_RESULT_OKAY) throw std::runtime_error("no solution");
  }

 private:
  template <class T>
  static std::uint32_t handle(const std::vector<T>& all) {
    return static_cast<std::uint32_t>(all.size()) + 1;
  }
  void make_plane() {
    const Slvs_hEntity origin = point(given, {0, 0, 0});
    const Slvs_hParam first = handle(params_);
    for (const double q : {1, 0, 0, 0}) params_.push_back(Slvs_MakeParam(handle(params_), given, q));
    entities_.push_back(Slvs_MakeNormal3d(handle(entities_), given, first, first + 1, first + 2, first + 3));
    entities_.push_back(Slvs_MakeWorkplane(handle(entities_), given, origin, entities_.back().h));
    plane_ = entities_.back().h;
  }

  std::vector<Slvs_Param> params_;
  std::vector<Slvs_Entity> entities_;
  std::vector<Slvs_Constraint> constraints_;
  Slvs_hEntity plane_ = SLVS_FREE_IN_3D;
};

class FourBarPeer : public Peer {
 public:
  FourBarPeer(int loops, const Row& start) {
    crank_ = sketch_.planar_point(Sketch::given, {FourBars::kCrank, 0, 0});
    Slvs_hEntity before = crank_;
    for (int i = 1; i <= loops; ++i) {
      const auto at = start.position.begin() + 2 * (i - 1);
      const Slvs_hEntity a = sketch_.planar_point(Sketch::given, {2.0 * i, 0, 0});
      points_.push_back(sketch_.planar_point(Sketch::sought, {at[0], at[1], 0}));
      sketch_.distance(before, points_.back(), FourBars::coupler(i));
      sketch_.distance(a, points_.back(), FourBars::kRocker);
      before = points_.back();
    }
  }
  void step(double t, Row& row) override {
    sketch_.move(crank_, FourBars::kCrank * heading(FourBars::kSpeed * t));
    sketch_.solve();
    for (std::size_t i = 0; i < points_.size(); ++i) sketch_.read(points_[i], 2, &row.position[2 * i]);
  }

 private:
  Sketch sketch_;
  Slvs_hEntity crank_ = 0;
  std::vector<Slvs_hEntity> points_;
};

// The end of a handle stays on its circle, because its distances from A and from another point of the axis are
// constraints.
class StewartPeer : public Peer {
 public:
  explicit StewartPeer(const Row& start) {
    for (std::size_t k = 0; k < 6; ++k) {
      const double* at = &start.position[3 * k];
      const Slvs_hEntity a = sketch_.point(Sketch::given, legs_[k].A);
      const Slvs_hEntity along = sketch_.point(Sketch::given, legs_[k].A + legs_[k].axis);
      joints_.push_back(sketch_.point(Sketch::given, Stewart::joint(legs_[k], start.t)));
      points_.push_back(sketch_.point(Sketch::sought, {at[0], at[1], at[2]}));
      sketch_.distance(a, points_.back(), Stewart::kHandle);
      sketch_.distance(along, points_.back(), std::hypot(Stewart::kHandle, 1));
      sketch_.distance(joints_.back(), points_.back(), Stewart::kRod);
    }
  }
  void step(double t, Row& row) override {
    for (std::size_t k = 0; k < 6; ++k) sketch_.move(joints_[k], Stewart::joint(legs_[k], t));
    sketch_.solve();
    for (std::size_t k = 0; k < 6; ++k) sketch_.read(points_[k], 3, &row.position[3 * k]);
  }

 private:
  Sketch sketch_;
  std::array<Stewart::Leg, 6> legs_ = Stewart::legs();
  std::vector<Slvs_hEntity> joints_, points_;
};

std::unique_ptr<Peer> make(const std::string& mechanism, int loops, const Row& start) {
  if (mechanism == "four_bar") return std::make_unique<FourBarPeer>(loops, start);
  return std::make_unique<StewartPeer>(start);
}

}  // namespace
}  // namespace peers

int main(int argc, char** argv) {
  return peers::run(argc, argv, {"libslvs 3.1", 1, "one group; from the posture before; scaled by 1e4", peers::make});
}
