// The path of a foot from lift-off to its foothold.
#pragma once

#include "core/geometry.h"

namespace atlas::sim {

struct SwingShape {
  core::Vec3 p_start = core::Vec3::Zero();   ///< foot centre at lift-off
  core::Vec3 p_target = core::Vec3::Zero();  ///< foot centre on the foothold
  double highest_z = 0.0;  ///< a foot centre that just touches the highest ground on the way
};

constexpr double kSwingClearanceM = 0.08;

/// Position at `s` in [0, 1]: quintic in x, y and two cubics in z over an apex kSwingClearanceM above
/// highest_z. Over a step the foot lifts first, then travels, then comes down.
core::Vec3 SwingPoint(const SwingShape& shape, double s);

}  // namespace atlas::sim
