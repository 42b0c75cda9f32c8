// What a robot knows when it plans.
#pragma once

#include "core/keyframe.h"
#include "mapping/map_view.h"
#include "mapping/terrain/traversable_ground.h"

namespace atlas::planner {

/// What a mission may still cost.
struct Budget {
  int scans = 0;
  double time_s = 0.0;
  double distance_m = 0.0;
};

/// Holds references: of one plan.
struct Belief {
  const mapping::MapView& map;
  const mapping::TraversableGround& ground;  ///< posed in the map
  const core::PoseSource& poses;             ///< of all keyframes so far, one at least
  core::Pose T_map_base = core::Pose::Identity();
  Budget left;

  core::Vec2 p_map() const { return T_map_base.translation().head<2>(); }
};

}  // namespace atlas::planner
