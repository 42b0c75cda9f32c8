// Where a swinging foot shall land.
#pragma once

#include "core/geometry.h"
#include "sim/locomotion/terrain_sampler.h"

namespace atlas::sim {

struct FootholdInput {
  core::Vec2 p_base = core::Vec2::Zero();
  core::Vec2 v_base = core::Vec2::Zero();
  core::Vec2 v_command = core::Vec2::Zero();   ///< map frame
  core::Vec2 com_offset = core::Vec2::Zero();  ///< centre of mass less base, map frame
  double yaw_rad = 0.0;
  double yaw_rate_command = 0.0;
  double height_m = 0.44;  ///< of the base above the ground
  double swing_left_s = 0.0;
  core::Vec2 nominal_base = core::Vec2::Zero();  ///< of this foot under the base
};

/// Raibert's rule with a capture-point term: under the hip when half the coming stance has passed, displaced
/// by the velocity error, at most 0.26 m from the nominal foot position.
core::Vec2 NominalFoothold(const FootholdInput& in);

struct Foothold {
  core::Vec2 offset = core::Vec2::Zero();  ///< from the nominal foothold, map frame
  double z = 0.0;                          ///< of the ground there
  bool steppable = true;
};

/// Searches round `nominal` for ground that is steppable, away from edges and not under a riser that the
/// shank would meet. A steppable place within the search window is always preferred to one that is not.
/// `knee_sign`: +1 where the shank leans forwards from the foot (hind legs), -1 backwards.
Foothold SearchFoothold(const TerrainSampler& terrain, const core::Vec2& nominal, double yaw_rad,
                        double knee_sign);

}  // namespace atlas::sim
