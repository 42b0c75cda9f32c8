// Ground heights for the gait, in the frame that physics runs in.
#pragma once

#include <functional>
#include <optional>

#include "core/terrain_view.h"

namespace atlas::sim {

/// z = z0 + slope_x (x - x0) + slope_y (y - y0)
struct GroundPlane {
  core::Vec3 origin = core::Vec3::Zero();
  core::Vec2 slope = core::Vec2::Zero();
  double At(double x, double y) const {
    return origin.z() + slope.x() * (x - origin.x()) + slope.y() * (y - origin.y());
  }
};

enum class GroundSource {
  kPlane,      ///< blind: the plane of the last footholds
  kPerceived,  ///< a TerrainView
  kTruth,
};

/// Reads a perceived map where the odometry believes the robot to be, or the true ground. Where neither
/// knows, it falls back to the plane of the last footholds.
class TerrainSampler {
 public:
  using TrueGround = std::function<std::optional<double>(const core::Vec3&)>;
  explicit TerrainSampler(TrueGround true_ground) : true_ground_(std::move(true_ground)) {}

  /// `view` is needed for kPerceived only, and must then outlive the use of that source.
  void SetSource(GroundSource source, const core::TerrainView* view = nullptr) {
    source_ = source;
    view_ = view;
  }
  /// From where things truly are to where odometry has them: T_odom_base * T_map_base^-1.
  void SetOdometry(const core::Pose& T_odom_map) { T_odom_map_ = T_odom_map; }
  void SetPlane(const GroundPlane& plane) { plane_ = plane; }
  const GroundPlane& plane() const { return plane_; }

  struct Sample {
    double z = 0.0;
    bool known = false;
    bool steppable = false;
  };
  Sample At(double x, double y) const;

 private:
  Sample Perceived(double x, double y, double z_plane) const;
  Sample Truth(double x, double y, double z_plane) const;

  TrueGround true_ground_;
  GroundSource source_ = GroundSource::kPlane;
  const core::TerrainView* view_ = nullptr;
  core::Pose T_odom_map_ = core::Pose::Identity();
  GroundPlane plane_;
};

}  // namespace atlas::sim
