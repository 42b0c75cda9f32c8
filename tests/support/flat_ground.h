// Flat traversable ground with obstacles, for planning tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "mapping/terrain/traversable_ground.h"

namespace atlas::tests {

/// A way on it.
inline std::vector<core::Vec3> OnFloor(const std::vector<core::Vec2>& way) {
  std::vector<core::Vec3> places;
  for (const core::Vec2& p : way) places.emplace_back(p.x(), p.y(), 0.0);
  return places;
}
/// Its points.
inline std::vector<core::Vec2> Flattened(const std::vector<core::Vec3>& way) {
  std::vector<core::Vec2> points;
  for (const core::Vec3& p : way) points.emplace_back(p.head<2>());
  return points;
}

/// z = 0, free except within boxes (x, y); a square window about the robot. The robot is a circle of 0.55 m
/// to CircleFree and a capsule of 0.33 m about 0.44 m of its length to FootprintFree.
class FlatGround : public mapping::TraversableGround {
 public:
  explicit FlatGround(double window_m = 12.0, const core::Vec2& robot = core::Vec2::Zero())
      : half_m_(0.5 * window_m), robot_(robot) {}
  void AddObstacle(const core::Vec2& min, const core::Vec2& max) { obstacles_.push_back({min, max}); }
  void SetRobot(const core::Vec2& robot) { robot_ = robot; }

  Levels LevelsAt(const core::Vec2& p) const override {
    Levels levels;
    if (InWindow(p)) levels.Add(0.0);
    return levels;
  }
  double Traversability(const core::Vec3& p) const override {
    return OnGround(p) && Clearance(p.head<2>()) > 0.0 ? 1.0 : 0.0;
  }
  mapping::GroundKind KindAt(const core::Vec3& p) const override {
    if (!OnGround(p)) return mapping::GroundKind::kUnknown;
    return Clearance(p.head<2>()) > 0.0 ? mapping::GroundKind::kFree : mapping::GroundKind::kObstacle;
  }
  bool FootprintFree(const core::Vec3& p, double yaw_rad) const override {
    const core::Vec3 along(std::cos(yaw_rad), std::sin(yaw_rad), 0.0);
    for (const double s : {-0.22, 0.0, 0.22}) {
      if (!OnGround(p + s * along) || Clearance((p + s * along).head<2>()) < 0.33) return false;
    }
    return true;
  }
  bool CircleFree(const core::Vec3& p) const override {
    return OnGround(p) && Clearance(p.head<2>()) >= 0.55;
  }
  Surface SurfaceAt(const core::Vec3&) const override { return {}; }
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
  bool OnGround(const core::Vec3& p) const {
    return InWindow(p.head<2>()) && std::abs(p.z()) <= kSameLevel_m;
  }
  bool InWindow(const core::Vec2& p) const { return (p - robot_).cwiseAbs().maxCoeff() <= half_m_; }
  double half_m_;
  core::Vec2 robot_;
  std::vector<std::pair<core::Vec2, core::Vec2>> obstacles_;
};

}  // namespace atlas::tests
