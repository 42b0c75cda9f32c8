// Where a ray becomes evidence in the elevation map: a height where it ends, an absence where it goes down
// through the height at which ground is expected.
#pragma once

#include "core/sensor_events.h"
#include "mapping/terrain/headroom_grid.h"
#include "mapping/terrain/layered_grid.h"

namespace atlas::mapping::terrain {

class RayIngest {
 public:
  /// @param grid,headroom  outlive this.
  RayIngest(LayeredGrid* grid, HeadroomGrid* headroom) : grid_(*grid), headroom_(*headroom) {}

  /// Ground under the robot; returns from more than 4 m below to 2.5 m above it are kept.
  void SetGround(float ground_m) { ground_m_ = ground_m; }
  float ground_m() const { return ground_m_; }

  /// Takes every ray from the LiDAR's pose at the ray's own time.
  void AddSpin(const core::SpinEvent& spin);
  /// Takes a share of the pixels; those on the robot itself (its legs, seen from its own camera) are left
  /// out.
  void AddDepth(const core::DepthEvent& event, const core::Pose& T_odom_base,
                const core::Vec2& half_footprint_m);
  void AddFoot(const core::Vec3& p_odom, double sigma_m);

 private:
  /// `direction` is that of the ray.
  void AddReturn(const core::Vec3f& p_odom, const core::Vec3f& direction, float variance_m2);
  /// The ray is clear from `origin` for `clear_m` along `direction` (unit).
  void AddClearRay(const core::Vec3f& origin, const core::Vec3f& direction, float clear_m);

  LayeredGrid& grid_;
  HeadroomGrid& headroom_;
  float ground_m_ = 0.0f;
};

}  // namespace atlas::mapping::terrain
