// The ground as planning asks for it: in the map.
#pragma once

#include "mapping/terrain/traversable_ground.h"

namespace atlas::mapping {

/// Shows ground that lives in the odometry frame in the map, as the robot is localised now. Upright: of the
/// localisation only its heading counts, and where it puts the robot; a tilt would lift what is far away.
class PosedGround final : public TraversableGround {
 public:
  /// `ground_odom` outlives this. Both poses are the robot's at one time.
  PosedGround(const TraversableGround& ground_odom, const core::Pose& T_map_base,
              const core::Pose& T_odom_base);

  Levels LevelsAt(const core::Vec2& p_map) const override;
  double Traversability(const core::Vec3& p_map) const override {
    return ground_.Traversability(ToOdom(p_map));
  }
  GroundKind KindAt(const core::Vec3& p_map) const override { return ground_.KindAt(ToOdom(p_map)); }
  bool FootprintFree(const core::Vec3& p_map, double yaw_rad) const override {
    return ground_.FootprintFree(ToOdom(p_map), yaw_rad - yaw_map_odom_);
  }
  bool CircleFree(const core::Vec3& p_map) const override { return ground_.CircleFree(ToOdom(p_map)); }
  Surface SurfaceAt(const core::Vec3& p_map) const override;
  /// About the same place, with sides along the map's axes.
  core::Box3 Window() const override;

 private:
  core::Vec2 ToOdom(const core::Vec2& p_map) const { return R_odom_map_ * (p_map - t_map_odom_); }
  core::Vec3 ToOdom(const core::Vec3& p_map) const {
    const core::Vec2 p_odom = ToOdom(core::Vec2(p_map.head<2>()));
    return {p_odom.x(), p_odom.y(), p_map.z() - lift_m_};
  }

  const TraversableGround& ground_;
  double yaw_map_odom_;
  Eigen::Matrix2d R_odom_map_;
  core::Vec2 t_map_odom_;
  double lift_m_;  ///< of map heights over those of odometry
};

}  // namespace atlas::mapping
