#include "sim/locomotion/locomotion.h"

#include "core/errors.h"
#include "sim/locomotion/makers.h"

namespace atlas::sim {

std::unique_ptr<Locomotion> MakeLocomotion(const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                                           const SimParams& params, const core::Rng& rng) {
  const std::string& name = params.locomotion.name;
  if (name == "trot") return MakeTrot(scene, robot, params, rng);
  if (name == "kinematic" || name == "rail") return MakeKinematic(scene, robot, params, rng);
  if (name == "carried") return MakeCarried(scene, robot, params, rng);
  throw core::InputError(core::UnknownName("locomotion", name, {"trot", "kinematic", "rail", "carried"}));
}

Vec12 NominalPosture(const World& world, double height_m) {
  Vec12 joints;
  for (int i = 0; i < kLegs; ++i) {
    const LegGeometry& leg = world.leg(i);
    const core::Vec3 p_foot(leg.fore * TrotController::kNominalFootX,
                            leg.side * TrotController::kNominalFootY, leg.foot_radius_m - height_m);
    joints.segment<3>(3 * i) = SolveLeg(leg, p_foot).q;
  }
  return joints;
}

}  // namespace atlas::sim
