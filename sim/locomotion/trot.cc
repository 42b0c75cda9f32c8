// The robot under physics: world, noise of its state estimate, gait, safety.
#include "sim/locomotion/makers.h"
#include "sim/locomotion/safety_monitor.h"
#include "sim/locomotion/state_noise.h"

namespace atlas::sim {
namespace {

constexpr double kSpawnGapM = 0.003;

std::array<LegGeometry, kLegs> LegsOf(const World& world) {
  return {world.leg(0), world.leg(1), world.leg(2), world.leg(3)};
}

class Trot : public Locomotion {
 public:
  Trot(const scenes::SceneSpec& scene, const robots::RobotSpec& robot, const OdometryParams& noise,
       const core::Rng& rng)
      : world_(scene, robot),
        terrain_([this](const core::Vec3& p) { return world_.GroundBelow(p); }),
        controller_(LegsOf(world_), robot.stance_height_m, &terrain_),
        noise_(noise.velocity_sigma_mps, core::Radians(noise.attitude_sigma_deg), rng.Split("state_noise")) {
    const core::Vec3 up(0.0, 0.0, robot.stance_height_m + kSpawnGapM);
    world_.Place(scene.T_map_spawn * Eigen::Translation3d(up), NominalPosture(world_, robot.stance_height_m));
  }

  void SetCommand(const VelocityCommand& command) override { controller_.SetCommand(command); }
  void SetRoll(const BodyRoll& roll) override { controller_.SetRoll(roll); }
  void SetTerrain(GroundSource source, const core::TerrainView* view) override {
    terrain_.SetSource(source, view);
  }
  void SetOdometry(const core::Pose& T_odom_base) override {
    terrain_.SetOdometry(T_odom_base * world_.T_map_base().inverse());
  }

  void BeginStep() override { world_.BeginStep(); }
  void FinishStep() override {
    const RobotState seen = noise_.Observe(world_.state(), World::kStepS);
    world_.FinishStep(controller_.Update(seen, world_, World::kStepS));
    monitor_.OnStep(world_, controller_);
  }

  double step_s() const override { return World::kStepS; }
  double time_s() const override { return world_.time_s(); }
  bool standing() const override { return controller_.standing(); }
  bool fallen() const override { return monitor_.fallen(); }
  core::Pose T_map_base() const override { return world_.T_map_base(); }
  FootStatus foot(int i) const override {
    const LegState& leg = world_.state().leg[static_cast<size_t>(i)];
    return {leg.p_foot - core::Vec3(0.0, 0.0, world_.leg(i).foot_radius_m), leg.normal_force_n > 8.0};
  }
  const SafetyCounts& safety() const override { return monitor_.counts(); }
  const World& world() const override { return world_; }

 private:
  World world_;
  TerrainSampler terrain_;
  TrotController controller_;
  StateNoise noise_;
  SafetyMonitor monitor_;
};

}  // namespace

std::unique_ptr<Locomotion> MakeTrot(const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                                     const SimParams& params, const core::Rng& rng) {
  return std::make_unique<Trot>(scene, robot, params.odometry, rng);
}

}  // namespace atlas::sim
