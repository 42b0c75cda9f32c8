// Trees whose crowns let part of the beams through, and hedges.
#pragma once

#include "core/rng.h"
#include "scenes/build/scene_builder.h"

namespace atlas::scenes {

struct TreeShape {
  double height_m = 9.0;
  double crown_radius_m = 2.8;
  double trunk_radius_m = 0.2;
  double clear_trunk_m = 2.2;  ///< below the crown
  int leaves = 240;            ///< clumps of foliage, each a small closed solid
};

/// A trunk with limbs, bent a little, and clumps of leaves in an ellipsoid about the limbs' ends. Physics is
/// the trunk.
void AddTree(SceneBuilder& scene, const core::Vec3& foot, const TreeShape& shape, core::Rng* rng);

/// A clipped hedge from `a` to `b` (on the ground): a solid heart in a coat of leaf clumps.
void AddHedge(SceneBuilder& scene, const core::Vec3& a, const core::Vec3& b, double height_m, double width_m,
              core::Rng* rng);

}  // namespace atlas::scenes
