// What stands about in parks and courts, and the plain buildings around them.
#pragma once

#include <string>

#include "scenes/build/scene_builder.h"

namespace atlas::scenes {

/// A slatted bench of 1.8 m at `foot`; who sits on it looks along yaw.
void AddBench(SceneBuilder& scene, const core::Vec3& foot, double yaw_rad);
/// A lamp post of 4 m with a lantern.
void AddLampPost(SceneBuilder& scene, const core::Vec3& foot);
/// A bollard of 0.9 m with a round head.
void AddBollard(SceneBuilder& scene, const core::Vec3& foot);
/// A litter bin of 0.9 m.
void AddBin(SceneBuilder& scene, const core::Vec3& foot);
/// A statue on a stepped plinth, 4.6 m in all.
void AddStatue(SceneBuilder& scene, const core::Vec3& foot);
/// A garden wall with coping and piers every 6 m, from `a` to `b`.
void AddGardenWall(SceneBuilder& scene, const core::Vec3& a, const core::Vec3& b, double height_m);

/// A block with four fronts and a gable roof whose ridge runs along its local x.
struct TownBlock {
  core::Vec3 middle = core::Vec3::Zero();  ///< of the floor plan, on the ground
  double yaw_rad = 0.0;
  double length_m = 16.0, depth_m = 9.0;
  int storeys = 2;
  double storey_m = 3.2;
  double roof_m = 3.0;           ///< of the ridge above the eaves; 0: a flat roof with a parapet
  bool fronts_all_round = true;  ///< else only the front at local -y has windows
  bool chimneys = true;
  double foot_m = -0.3;
  std::string name = "building";
};
void AddTownBlock(SceneBuilder& scene, const TownBlock& block);

/// A gable roof over a plan of `length` x `depth` about `T_map_eaves`, eaves at its z = 0, ridge along x.
void AddGableRoof(SceneBuilder& scene, const std::string& name, const core::Pose& T_map_eaves,
                  double length_m, double depth_m, double ridge_m);

}  // namespace atlas::scenes
