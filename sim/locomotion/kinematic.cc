// The robot without physics: the base follows its command over the true ground, the feet step where they
// must.
#include "sim/locomotion/makers.h"
#include "sim/locomotion/swing_trajectory.h"

namespace atlas::sim {
namespace {

using core::Vec2;
using core::Vec3;

constexpr double kStepS = 0.005;
constexpr double kLinearAcceleration = 1.5, kYawAcceleration = 4.0;
constexpr double kHeightTauS = 0.15;
constexpr double kProbeAboveM = 0.6, kPitM = 1.0;

double Toward(double from, double to, double limit) {
  return from + std::clamp(to - from, -limit, limit);
}

class Kinematic : public Locomotion {
 public:
  Kinematic(const scenes::SceneSpec& scene, const robots::RobotSpec& robot)
      : world_(scene, robot), height_m_(robot.stance_height_m) {
    counts_.measured = false;
    p_base_ = scene.T_map_spawn.translation() + Vec3(0.0, 0.0, height_m_);
    yaw_ = core::YawOf(scene.T_map_spawn.linear());
    for (int i = 0; i < kLegs; ++i) {
      foot_[i].p_from = foot_[i].p = foot_[i].p_to = OnGround(Nominal(i, Vec2::Zero()));
    }
    Place();
  }

  void SetCommand(const VelocityCommand& command) override { command_ = command; }
  void SetRoll(const BodyRoll& roll) override { roll_ = roll; }
  void SetTerrain(GroundSource, const core::TerrainView*) override {}
  void SetOdometry(const core::Pose&) override {}
  void BeginStep() override {}
  void FinishStep() override {
    MoveBase();
    MoveFeet();
    Place();
    time_s_ = static_cast<double>(++steps_) * kStepS;
  }

  double step_s() const override { return kStepS; }
  double time_s() const override { return time_s_; }
  bool standing() const override { return !gait_on_; }
  bool fallen() const override { return false; }
  core::Pose T_map_base() const override { return T_map_base_; }
  FootStatus foot(int i) const override { return {foot_[i].p, !foot_[i].swing}; }
  const SafetyCounts& safety() const override { return counts_; }
  const World& world() const override { return world_; }

 private:
  struct Foot {
    bool swing = false;
    Vec3 p_from = Vec3::Zero(), p_to = Vec3::Zero(), p = Vec3::Zero();  ///< soles
  };

  Vec2 Nominal(int i, const Vec2& ahead) const {
    const LegGeometry& leg = world_.leg(i);
    const Vec2 offset(leg.fore * TrotController::kNominalFootX, leg.side * TrotController::kNominalFootY);
    return p_base_.head<2>() + Eigen::Rotation2Dd(yaw_) * Vec2(offset + ahead);
  }

  Vec3 OnGround(const Vec2& p) const {
    const double z_feet = p_base_.z() - height_m_;
    const auto z = world_.GroundBelow({p.x(), p.y(), z_feet + kProbeAboveM});
    const bool usable = z && *z<z_feet + kProbeAboveM&& * z> z_feet - kPitM;
    return {p.x(), p.y(), usable ? *z : z_feet};
  }

  void MoveBase() {
    velocity_.x() = Toward(velocity_.x(), command_.forward_mps, kLinearAcceleration * kStepS);
    velocity_.y() = Toward(velocity_.y(), command_.lateral_mps, kLinearAcceleration * kStepS);
    velocity_.z() = Toward(velocity_.z(), command_.yaw_radps, kYawAcceleration * kStepS);
    yaw_ = core::WrapAngle(yaw_ + velocity_.z() * kStepS);
    p_base_.head<2>() += Eigen::Rotation2Dd(yaw_) * Vec2(velocity_.head<2>()) * kStepS;
    double z = height_m_;
    for (const Foot& foot : foot_) z += 0.25 * foot.p_to.z();
    p_base_.z() += kStepS / kHeightTauS * (z - p_base_.z());
  }

  void MoveFeet() {
    const bool moving = !command_.zero() || velocity_.norm() > 1e-3;
    bool all_stand = true;
    for (const Foot& foot : foot_) all_stand = all_stand && !foot.swing;
    if (moving && !gait_on_) {
      gait_on_ = true;
      gait_.Restart();
    } else if (!moving && all_stand && gait_on_ && FeetPlaced()) {
      gait_on_ = false;
    }
    if (!gait_on_) return;
    gait_.Advance(kStepS);
    for (int i = 0; i < kLegs; ++i) {
      Foot& foot = foot_[i];
      if (!gait_.InSwing(i)) {
        if (foot.swing) foot.p = foot.p_to;
        foot.swing = false;
        continue;
      }
      if (!foot.swing) {
        foot.swing = true;
        foot.p_from = foot.p;
        foot.p_to = OnGround(
            Nominal(i, velocity_.head<2>() * (GaitSchedule::kSwingS + 0.5 * GaitSchedule::kStanceS)));
        ++counts_.footholds;
      }
      foot.p = SwingPoint({foot.p_from, foot.p_to, std::max(foot.p_from.z(), foot.p_to.z())},
                          gait_.SwingProgress(i));
    }
  }

  bool FeetPlaced() const {
    for (int i = 0; i < kLegs; ++i) {
      if ((foot_[i].p.head<2>() - Nominal(i, Vec2::Zero())).norm() > 0.05) return false;
    }
    return true;
  }

  void Place() {
    T_map_base_ = core::MakePose(core::RotationFromYawPitchRoll(yaw_, 0.0, roll_.roll_rad), p_base_);
    Vec12 joints;
    for (int i = 0; i < kLegs; ++i) {
      const Vec3 p_centre = foot_[i].p + Vec3(0.0, 0.0, world_.leg(i).foot_radius_m);
      joints.segment<3>(3 * i) = SolveLeg(world_.leg(i), T_map_base_.inverse() * p_centre).q;
    }
    world_.Place(T_map_base_, joints);
  }

  World world_;
  double height_m_;
  int64_t steps_ = 0;
  double time_s_ = 0.0;
  VelocityCommand command_;
  BodyRoll roll_;
  Vec3 velocity_ = Vec3::Zero();  ///< forward, lateral, yaw
  Vec3 p_base_ = Vec3::Zero();
  double yaw_ = 0.0;
  bool gait_on_ = false;
  GaitSchedule gait_;
  std::array<Foot, kLegs> foot_;
  core::Pose T_map_base_ = core::Pose::Identity();
  SafetyCounts counts_;
};

}  // namespace

std::unique_ptr<Locomotion> MakeKinematic(const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                                          const SimParams&, const core::Rng&) {
  return std::make_unique<Kinematic>(scene, robot);
}

}  // namespace atlas::sim
