// Simbody: rockers or handles on pins, closed by rods; the driver is a prescribed motion. Position and velocity by
// projection; acceleration from the constrained equations of motion, because Simbody offers no other way.
#include <Simbody.h>

#include <stdexcept>
#include <utility>

#include "mechanisms.hpp"
#include "peer.hpp"

namespace peers {
namespace {

using namespace SimTK;

constexpr double kAccuracy = 1e-12;  // accuracy of the projections, in Simbody's own unit for each equation

Vec3 vec3(const Vec& v) { return {v[0], v[1], v[2]}; }

// The mass is arbitrary, because it does not influence the motion.
Body::Rigid body() { return Body::Rigid(MassProperties(1, Vec3(0), Inertia(1))); }

// An angle with constant speed; Motion::Steady would prescribe only the speed.
class Turning : public Motion::Custom::Implementation {
 public:
  explicit Turning(double speed) : speed_(speed) {}
  Motion::Level getLevel(const State&) const override { return Motion::Position; }
  void calcPrescribedPosition(const State& state, int, Real* q) const override { q[0] = speed_ * state.getTime(); }
  void calcPrescribedPositionDot(const State&, int, Real* rate) const override { rate[0] = speed_; }
  void calcPrescribedPositionDotDot(const State&, int, Real* acceleration) const override { acceleration[0] = 0; }

 private:
  double speed_;
};

class SimbodyPeer : public Peer {
 public:
  void step(double t, Row& row) override {
    predict(t - state_.getTime());
    state_.setTime(t);
    system_.realize(state_, Stage::Time);
    system_.prescribeQ(state_);
    system_.projectQ(state_, kAccuracy);
    system_.realize(state_, Stage::Position);
    system_.prescribeU(state_);
    system_.projectU(state_, kAccuracy);
    system_.realize(state_, Stage::Acceleration);
    const std::size_t n = row.position.size() / ends_.size();
    for (std::size_t i = 0; i < ends_.size(); ++i) {
      const auto& [mobod, station] = ends_[i];
      const Vec3 p = mobod.findStationLocationInGround(state_, station);
      const Vec3 v = mobod.findStationVelocityInGround(state_, station);
      const Vec3 a = mobod.findStationAccelerationInGround(state_, station);
      for (std::size_t k = 0; k < n; ++k) {
        row.position[n * i + k] = p[static_cast<int>(k)];
        row.velocity[n * i + k] = v[static_cast<int>(k)];
        row.acceleration[n * i + k] = a[static_cast<int>(k)];
      }
    }
  }

 protected:
  void begin(double t) {
    state_ = system_.realizeTopology();
    state_.setTime(t);
    system_.realizeModel(state_);
  }

  // Predicts by a Taylor series as soon as derivatives exist: all coordinates are angles and lengths, so that their
  // rates are the speeds of Simbody.
  void predict(double dt) {
    if (state_.getSystemStage() < Stage::Acceleration) return;
    const Vector ahead = state_.getQ() + dt * state_.getU() + (0.5 * dt * dt) * state_.getUDot();
    state_.updQ() = ahead;
  }

  MultibodySystem system_;
  SimbodyMatterSubsystem matter_{system_};
  State state_;
  std::vector<std::pair<MobilizedBody, Vec3>> ends_;  // B1, B2, ... with their places on their bodies
};

class FourBarPeer : public SimbodyPeer {
 public:
  FourBarPeer(int loops, const Row& start) {
    MobilizedBody::Pin crank(matter_.Ground(), Transform(Vec3(0)), body(), Transform(Vec3(0)));
    Motion::Custom(crank, new Turning(FourBars::kSpeed));  // the crank owns it
    std::pair<MobilizedBody, Vec3> before(crank, Vec3(FourBars::kCrank, 0, 0));
    std::vector<MobilizedBody::Pin> rockers;
    for (int i = 1; i <= loops; ++i) {
      rockers.emplace_back(matter_.Ground(), Transform(Vec3(2.0 * i, 0, 0)), body(), Transform(Vec3(0)));
      ends_.emplace_back(rockers.back(), Vec3(FourBars::kRocker, 0, 0));
      Constraint::Rod(before.first, before.second, rockers.back(), ends_.back().second, FourBars::coupler(i));
      before = ends_.back();
    }
    begin(start.t);
    crank.setAngle(state_, FourBars::kSpeed * start.t);
    for (int i = 0; i < loops; ++i) {
      const double* at = &start.position[static_cast<std::size_t>(2 * i)];
      rockers[static_cast<std::size_t>(i)].setAngle(state_, std::atan2(at[1], at[0] - 2.0 * (i + 1)));
    }
  }
};

class StewartPeer : public SimbodyPeer {
 public:
  explicit StewartPeer(const Row& start) {
    // The pose as six joints in series: along x, y, z, then about z, y, x.
    const Rotation slides[] = {Rotation(), Rotation(Pi / 2, ZAxis), Rotation(-Pi / 2, YAxis)};
    const Rotation pins[] = {Rotation(), Rotation(-Pi / 2, XAxis), Rotation(Pi / 2, YAxis)};
    MobilizedBody terminal = matter_.Ground();
    for (std::size_t k = 0; k < 6; ++k) {
      const Rotation& axis = k < 3 ? slides[k] : pins[k - 3];
      const Vec3 at = k == 2 ? Vec3(0, 0, Stewart::kPose[2].offset) : Vec3(0);
      if (k < 3) {
        terminal = MobilizedBody::Slider(terminal, Transform(axis, at), body(), Transform(axis, Vec3(0)));
      } else {
        terminal = MobilizedBody::Pin(terminal, Transform(axis, at), body(), Transform(axis, Vec3(0)));
      }
      Motion::Sinusoid(terminal, Motion::Position, Stewart::kPose[k].amplitude, 1, Stewart::kPose[k].phase);
    }
    std::vector<MobilizedBody::Pin> handles;
    const auto legs = Stewart::legs();
    for (const Stewart::Leg& leg : legs) {
      const Rotation hinge(UnitVec3(vec3(leg.axis)), ZAxis);
      handles.emplace_back(matter_.Ground(), Transform(hinge, vec3(leg.A)), body(), Transform(Vec3(0)));
      ends_.emplace_back(handles.back(), Vec3(Stewart::kHandle, 0, 0));
      Constraint::Rod(handles.back(), ends_.back().second, terminal, vec3(leg.P), Stewart::kRod);
    }
    begin(start.t);
    for (std::size_t k = 0; k < 6; ++k) {
      const Rotation hinge(UnitVec3(vec3(legs[k].axis)), ZAxis);
      const double* at = &start.position[3 * k];
      const Vec3 arm = ~hinge * (Vec3(at[0], at[1], at[2]) - vec3(legs[k].A));
      handles[k].setAngle(state_, std::atan2(arm[1], arm[0]));
    }
  }
};

std::unique_ptr<Peer> make(const std::string& mechanism, int loops, const Row& start) {
  if (mechanism == "four_bar") return std::make_unique<FourBarPeer>(loops, start);
  return std::make_unique<StewartPeer>(start);
}

}  // namespace
}  // namespace peers

int main(int argc, char** argv) {
  return peers::run(
      argc, argv,
      {"Simbody 3.7", 3, "pins and rods; projectQ and projectU to 1e-12 from a Taylor prediction", peers::make});
}
