// A LiDAR carried along a route, by hand or in the air: no robot, no physics. It goes along the route's curve
// at the route's speed, faces ahead but turns no faster than the route allows, glances aside now and then,
// and sways as the route says: smooth random motion that the run's seed decides.
#include <algorithm>
#include <cmath>

#include "scenes/route.h"
#include "sim/locomotion/makers.h"

namespace atlas::sim {
namespace {

using core::Vec2;
using core::Vec3;

constexpr double kCarriedStepS = 0.005;
constexpr double kAccelerationMps2 = 1.0, kBrakingMps2 = 0.8;
constexpr double kPassM = 2.0;  ///< the route passes a place where it comes this near, on the plan
constexpr double kAtGoalM = 0.02;
constexpr double kTurnGain = 3.0;          ///< rad/s a radian of heading error, up to the route's limit
constexpr double kTurnAcceleration = 8.0;  ///< rad/s^2
constexpr double kGlanceEveryS = 20.0, kGlanceLastsS = 1.6;
constexpr double kStandingShare = 0.3;  ///< of the sway is left where the carrier stands

/// Smooth random motion about a frequency: tones around it with random phases, at most `amplitude`.
class Tones {
 public:
  Tones(double amplitude, double hz, core::Rng rng) : amplitude_(amplitude) {
    for (size_t k = 0; k < kTones; ++k) {
      hz_[k] = hz * (0.85 + 0.15 * static_cast<double>(k));
      phase_[k] = rng.Uniform(0.0, 2.0 * core::kPi);
    }
  }
  double At(double time_s) const {
    double sum = 0.0;
    for (size_t k = 0; k < kTones; ++k)
      sum += kShare[k] * std::sin(2.0 * core::kPi * hz_[k] * time_s + phase_[k]);
    return amplitude_ * sum;
  }

 private:
  static constexpr size_t kTones = 3;
  static constexpr double kShare[kTones] = {0.25, 0.5, 0.25};
  double amplitude_;
  double hz_[kTones] = {}, phase_[kTones] = {};
};

/// When the carrier looks aside, and how far.
class Glances {
 public:
  Glances(double most_rad, core::Rng rng) : most_rad_(most_rad), rng_(std::move(rng)) { Draw(0.0); }
  double At(double time_s) {
    if (time_s > begin_s_ + kGlanceLastsS) Draw(time_s);
    return time_s < begin_s_ ? 0.0 : aside_rad_;
  }

 private:
  void Draw(double now_s) {
    begin_s_ = now_s + rng_.Uniform(0.5, 1.5) * kGlanceEveryS;
    aside_rad_ = most_rad_ * rng_.Uniform(0.5, 1.0) * (rng_.UniformInt(2) == 0 ? 1.0 : -1.0);
  }
  double most_rad_;
  core::Rng rng_;
  double begin_s_ = 0.0, aside_rad_ = 0.0;
};

class Carried : public Locomotion {
 public:
  Carried(const scenes::SceneSpec& scene, const robots::RobotSpec& robot, const std::string& route,
          const core::Rng& rng)
      : world_(scene, robot),
        route_(scenes::LoadRoute(scenes::DefaultRouteOf(route.empty() ? scene.name : route))),
        curve_(route_,
               [this](double x, double y, double z) {
                 return world_.GroundBelow({x, y, z});
               }),
        T_lidar_base_(robot.T_base_lidar.inverse()),
        joints_(NominalPosture(world_, robot.stance_height_m)),
        roll_(core::Radians(route_.sway.roll_deg), route_.sway.step_hz, rng.Split("roll")),
        pitch_(core::Radians(route_.sway.pitch_deg), route_.sway.step_hz, rng.Split("pitch")),
        wobble_(core::Radians(route_.sway.yaw_deg), 0.5 * route_.sway.step_hz, rng.Split("yaw")),
        bob_(route_.sway.bob_m, route_.sway.step_hz, rng.Split("bob")),
        glances_(core::Radians(route_.sway.glance_deg), rng.Split("glances")),
        yaw_(curve_.YawAt(0.0)) {
    counts_.measured = false;
    Place();
  }

  void SetCommand(const VelocityCommand&) override {}
  void SetRoll(const BodyRoll&) override {}
  void SetTerrain(GroundSource, const core::TerrainView*) override {}
  void SetOdometry(const core::Pose&) override {}
  bool carried() const override { return true; }

  bool CarryTo(const Vec2& p_map) override {
    bool left = Away(along_m_, p_map) > kPassM;
    std::optional<double> best_m;
    for (double s = along_m_; s <= curve_.length_m(); s += 0.5 * kCurveStepM) {
      const double away = Away(s, p_map);
      left = left || away > kPassM;
      if (!left) continue;
      if (away > kPassM) {
        if (best_m) break;
      } else if (!best_m || away < Away(*best_m, p_map)) {
        best_m = s;
      }
    }
    if (best_m) goal_m_ = *best_m;
    return best_m.has_value();
  }

  void BeginStep() override {}
  void FinishStep() override {
    time_s_ = static_cast<double>(++steps_) * kCarriedStepS;
    Advance();
    Turn();
    Place();
  }

  double step_s() const override { return kCarriedStepS; }
  double time_s() const override { return time_s_; }
  bool standing() const override { return speed_mps_ == 0.0 && goal_m_ - along_m_ < kAtGoalM; }
  bool fallen() const override { return false; }
  core::Pose T_map_base() const override { return T_map_base_; }
  FootStatus foot(int) const override { return {T_map_base_.translation(), false}; }
  const SafetyCounts& safety() const override { return counts_; }
  const World& world() const override { return world_; }

 private:
  static constexpr double kCurveStepM = 0.1;

  double Away(double along_m, const Vec2& p_map) const {
    return (curve_.At(along_m).head<2>() - p_map).norm();
  }

  void Advance() {
    const double left_m = goal_m_ - along_m_;
    const double brake = std::sqrt(2.0 * kBrakingMps2 * std::max(0.0, left_m));
    const double wanted = std::min(route_.speed_m_s, brake);
    speed_mps_ = std::min(wanted, speed_mps_ + kAccelerationMps2 * kCarriedStepS);
    if (left_m < kAtGoalM) speed_mps_ = 0.0;
    along_m_ = std::min(goal_m_, along_m_ + speed_mps_ * kCarriedStepS);
  }

  void Turn() {
    const double limit = core::Radians(route_.sway.turn_deg_s);
    const double error = curve_.YawAt(along_m_) + glances_.At(time_s_) - yaw_;
    const double wanted = std::clamp(kTurnGain * error, -limit, limit);
    const double most = kTurnAcceleration * kCarriedStepS;
    yaw_rate_ += std::clamp(wanted - yaw_rate_, -most, most);
    yaw_ += yaw_rate_ * kCarriedStepS;
    const double share =
        kStandingShare + (1.0 - kStandingShare) * std::min(1.0, speed_mps_ / route_.speed_m_s);
    liveliness_ += (share - liveliness_) * kCarriedStepS / 0.5;
  }

  void Place() {
    Vec3 p = curve_.At(along_m_);
    p.z() += liveliness_ * bob_.At(time_s_);
    const core::Mat3 R =
        core::RotationFromYawPitchRoll(yaw_ + liveliness_ * wobble_.At(time_s_),
                                       liveliness_ * pitch_.At(time_s_), liveliness_ * roll_.At(time_s_));
    T_map_base_ = core::MakePose(R, p) * T_lidar_base_;
    world_.Place(T_map_base_, joints_);
  }

  World world_;  ///< where the ground is; the robot's body is carried along for films and met by no ray
  scenes::Route route_;
  scenes::RouteCurve curve_;
  core::Pose T_lidar_base_;
  Vec12 joints_;
  Tones roll_, pitch_, wobble_, bob_;
  Glances glances_;
  double along_m_ = 0.0, goal_m_ = 0.0, speed_mps_ = 0.0;
  double yaw_ = 0.0, yaw_rate_ = 0.0, liveliness_ = kStandingShare;
  int64_t steps_ = 0;
  double time_s_ = 0.0;
  core::Pose T_map_base_ = core::Pose::Identity();
  SafetyCounts counts_;
};

}  // namespace

std::unique_ptr<Locomotion> MakeCarried(const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                                        const SimParams& params, const core::Rng& rng) {
  return std::make_unique<Carried>(scene, robot, params.locomotion.route, rng);
}

}  // namespace atlas::sim
