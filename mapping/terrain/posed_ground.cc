#include "mapping/terrain/posed_ground.h"

namespace atlas::mapping {

using core::Vec2;

PosedGround::PosedGround(const TraversableGround& ground_odom, const core::Pose& T_map_base,
                         const core::Pose& T_odom_base)
    : ground_(ground_odom),
      yaw_map_odom_(core::YawOf((T_map_base * T_odom_base.inverse()).linear())),
      R_odom_map_(Eigen::Rotation2Dd(-yaw_map_odom_).toRotationMatrix()),
      t_map_odom_(T_map_base.translation().head<2>() -
                  R_odom_map_.transpose() * T_odom_base.translation().head<2>()),
      lift_m_(T_map_base.translation().z() - T_odom_base.translation().z()) {}

TraversableGround::Levels PosedGround::LevelsAt(const Vec2& p_map) const {
  Levels levels = ground_.LevelsAt(ToOdom(p_map));
  for (int k = 0; k < levels.count; ++k) levels.height_m[static_cast<size_t>(k)] += lift_m_;
  return levels;
}

TraversableGround::Surface PosedGround::SurfaceAt(const core::Vec3& p_map) const {
  Surface surface = ground_.SurfaceAt(ToOdom(p_map));
  surface.height_m += lift_m_;
  return surface;
}

core::Box3 PosedGround::Window() const {
  const core::Box3 window = ground_.Window();
  const Vec2 centre = t_map_odom_ + R_odom_map_.transpose() * window.Center().head<2>();
  const core::Vec3 half = 0.5 * window.Size();
  const core::Vec3 middle(centre.x(), centre.y(), window.Center().z() + lift_m_);
  return {middle - half, middle + half};
}

}  // namespace atlas::mapping
