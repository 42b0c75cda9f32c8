// Closed-form kinematics of a three-joint leg: HAA about x, then HFE and KFE about y.
#pragma once

#include "core/geometry.h"

namespace atlas::sim {

struct LegGeometry {
  core::Vec3 haa_base = core::Vec3::Zero();  ///< abduction joint in the base frame
  double hfe_forward_m = 0.0;                ///< signed x from HAA to HFE
  double lateral_m = 0.0;                    ///< signed y from the HAA axis to the foot's plane
  double thigh_m = 0.0;
  double shank_m = 0.0;
  double foot_radius_m = 0.0;
  double fore = 1.0;  ///< +1 front leg (knee bends backwards), -1 hind leg
  double side = 1.0;  ///< +1 left, -1 right
};

struct LegAngles {
  core::Vec3 q = core::Vec3::Zero();  ///< HAA, HFE, KFE
  bool reachable = false;             ///< false: q is the nearest posture, stretched or folded
};

/// Foot centre in the base frame.
core::Vec3 FootPosition(const LegGeometry& leg, const core::Vec3& q);

/// Inverse of FootPosition for the knee direction of the leg (X knees).
LegAngles SolveLeg(const LegGeometry& leg, const core::Vec3& p_foot_base);

}  // namespace atlas::sim
