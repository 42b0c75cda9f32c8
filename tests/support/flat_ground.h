// Flat traversable ground with obstacles, for planning tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "mapping/terrain/traversable_ground.h"

namespace atlas::tests {

/// z = 0, free except within boxes (x, y); a square window about the robot. The robot is a circle of 0.55 m
/// to CircleFree and a capsule of 0.33 m about 0.44 m of its length to FootprintFree.
class FlatGround : public mapping::TraversableGround {
 public:
  explicit FlatGround(double window_m = 12.0, const core::Vec2& robot = core::Vec2::Zero())
      : half_m_(0.5 * window_m), robot_(robot) {}
  void AddObstacle(const core::Vec2& min, const core::Vec2& max) { obstacles_.push_back({min, max}); }
  void SetRobot(const core::Vec2& robot) { robot_ = robot; }

  double Traversability(const core::Vec2& p) const override {
    return InWindow(p) && Clearance(p) > 0.0 ? 1.0 : 0.0;
  }
  mapping::GroundKind KindAt(const core::Vec2& p) const override {
    if (!InWindow(p)) return mapping::GroundKind::kUnknown;
    return Clearance(p) > 0.0 ? mapping::GroundKind::kFree : mapping::GroundKind::kObstacle;
  }
  bool FootprintFree(const core::Vec2& p, double yaw_rad) const override {
    const core::Vec2 along(std::cos(yaw_rad), std::sin(yaw_rad));
    for (const double s : {-0.22, 0.0, 0.22}) {
      if (!InWindow(p + s * along) || Clearance(p + s * along) < 0.33) return false;
    }
    return true;
  }
  bool CircleFree(const core::Vec2& p) const override { return InWindow(p) && Clearance(p) >= 0.55; }
  Surface SurfaceAt(const core::Vec2&) const override { return {}; }
  core::Box3 Window() const override {
    return {core::Vec3(robot_.x() - half_m_, robot_.y() - half_m_, -1.0),
            core::Vec3(robot_.x() + half_m_, robot_.y() + half_m_, 3.0)};
  }
  /// Distance to the nearest obstacle; negative inside one.
  double Clearance(const core::Vec2& p) const {
    double nearest = 1e9;
    for (const auto& [min, max] : obstacles_) {
      const core::Vec2 outside = (min - p).cwiseMax(p - max);
      nearest = std::min(nearest, outside.cwiseMax(0.0).norm() + std::min(0.0, outside.maxCoeff()));
    }
    return nearest;
  }

 private:
  bool InWindow(const core::Vec2& p) const { return (p - robot_).cwiseAbs().maxCoeff() <= half_m_; }
  double half_m_;
  core::Vec2 robot_;
  std::vector<std::pair<core::Vec2, core::Vec2>> obstacles_;
};

}  // namespace atlas::tests
