// How the robot gets about: under physics or kinematically. One instance owns the robot's state and clock.
#pragma once

#include <memory>

#include "core/rng.h"
#include "sim/locomotion/body_reference.h"
#include "sim/locomotion/terrain_sampler.h"
#include "sim/locomotion/trot_controller.h"
#include "sim/simulator.h"
#include "sim/world/world.h"

namespace atlas::sim {

struct FootStatus {
  core::Vec3 p_sole = core::Vec3::Zero();  ///< map
  bool in_contact = false;
};

class Locomotion {
 public:
  virtual ~Locomotion() = default;

  virtual void SetCommand(const VelocityCommand& command) = 0;
  virtual void SetRoll(const BodyRoll& roll) = 0;
  /// What footholds are chosen on, see TerrainSampler::SetSource.
  virtual void SetTerrain(GroundSource source, const core::TerrainView* view) = 0;
  /// The odometry's T_odom_base, whenever that changes: where perceived ground is looked up.
  virtual void SetOdometry(const core::Pose& T_odom_base) = 0;

  /// Goes along a route of its own, without a body: commands and rolls are not for it, CarryTo is.
  virtual bool carried() const { return false; }
  /// Sets off to where its route next comes by `p_map` (2 m on the plan); false where it never does again.
  virtual bool CarryTo(const core::Vec2&) { return false; }

  /// Brings the readable state up to time_s(); then reads, then FinishStep() advances the clock by step_s().
  virtual void BeginStep() = 0;
  virtual void FinishStep() = 0;

  virtual double step_s() const = 0;
  virtual double time_s() const = 0;
  virtual bool standing() const = 0;
  virtual bool fallen() const = 0;
  virtual core::Pose T_map_base() const = 0;
  virtual FootStatus foot(int i) const = 0;
  virtual const SafetyCounts& safety() const = 0;
  /// For body poses, meshes and the state vector.
  virtual const World& world() const = 0;
};

/// `name` of LocomotionParams decides. @throws InputError for an unknown name.
std::unique_ptr<Locomotion> MakeLocomotion(const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                                           const SimParams& params, const core::Rng& rng);

/// Joint angles that put the feet at their nominal places, `height_m` below the base.
Vec12 NominalPosture(const World& world, double height_m);

}  // namespace atlas::sim
