// What the gait may know of the ground.
#pragma once

#include "core/geometry.h"

namespace atlas::core {

/// Heights of the ground in the odometry frame, as perceived: what feet step on must not move when the robot
/// learns where it is.
class TerrainView {
 public:
  virtual ~TerrainView() = default;

  struct Ground {
    double height_m = 0.0;   ///< z of the supporting surface in the odometry frame; meaningful where known
    bool known = false;      ///< measured or filled to a stated size
    bool steppable = false;  ///< a foot may be placed: known, solid support, not beside a drop or at an edge
  };
  virtual Ground At(double x_odom, double y_odom) const = 0;
};

}  // namespace atlas::core
