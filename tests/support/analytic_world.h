// Scenes of planes, boxes, cylinders and spheres whose ray intersections are closed forms, and revolutions of
// a LiDAR through them.
#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "core/geometry.h"
#include "core/lidar_model.h"
#include "core/rng.h"
#include "core/sensor_events.h"

namespace atlas::tests {

class AnalyticWorld {
 public:
  /// n . x = offset, seen from both sides.
  void AddPlane(const core::Vec3& normal, double offset) { planes_.push_back({normal.normalized(), offset}); }
  void AddBox(const core::Box3& box) { boxes_.push_back(box); }
  /// Upright, capless.
  void AddPillar(double x, double y, double radius, double bottom, double top) {
    pillars_.push_back({x, y, radius, bottom, top});
  }
  void AddSphere(const core::Vec3& center, double radius) { spheres_.push_back({center, radius}); }

  /// Range of the first surface, infinity where none. @pre direction is unit.
  double Cast(const core::Vec3& o, const core::Vec3& d) const {
    double best = std::numeric_limits<double>::infinity();
    const auto offer = [&best](double t) {
      if (t > 1e-6 && t < best) best = t;
    };
    for (const Plane& p : planes_) offer((p.offset - p.normal.dot(o)) / p.normal.dot(d));
    for (const core::Box3& box : boxes_) {
      double first = -std::numeric_limits<double>::infinity(), last = -first;
      for (int a = 0; a < 3; ++a) {
        const double t0 = (box.min[a] - o[a]) / d[a], t1 = (box.max[a] - o[a]) / d[a];
        first = std::max(first, std::min(t0, t1));
        last = std::min(last, std::max(t0, t1));
      }
      if (first > last) continue;
      offer(first);
      offer(last);
    }
    for (const Pillar& p : pillars_) {
      const double ox = o.x() - p.x, oy = o.y() - p.y;
      const double a = d.x() * d.x() + d.y() * d.y(), b = ox * d.x() + oy * d.y(),
                   c = ox * ox + oy * oy - p.radius * p.radius, root = b * b - a * c;
      if (root < 0.0 || a < 1e-12) continue;
      for (const double t : {(-b - std::sqrt(root)) / a, (-b + std::sqrt(root)) / a}) {
        const double z = o.z() + t * d.z();
        if (z >= p.bottom && z <= p.top) offer(t);
      }
    }
    for (const Sphere& s : spheres_) {
      const core::Vec3 v = o - s.center;
      const double b = v.dot(d), root = b * b - v.squaredNorm() + s.radius * s.radius;
      if (root < 0.0) continue;
      offer(-b - std::sqrt(root));
      offer(-b + std::sqrt(root));
    }
    return best;
  }

 private:
  struct Plane {
    core::Vec3 normal;
    double offset;
  };
  struct Pillar {
    double x, y, radius, bottom, top;
  };
  struct Sphere {
    core::Vec3 center;
    double radius;
  };
  std::vector<Plane> planes_;
  std::vector<core::Box3> boxes_;
  std::vector<Pillar> pillars_;
  std::vector<Sphere> spheres_;
};

/// One revolution along `T_map_lidar` from stamp_s. Rays that meet nothing within the model's range are void.
inline core::SpinEvent SpinThrough(const AnalyticWorld& world, const core::LidarModel& lidar, double stamp_s,
                                   const core::PoseTrajectory& T_map_lidar, core::Rng* noise = nullptr) {
  core::SpinEvent spin;
  spin.T_odom_lidar = T_map_lidar;
  core::LidarScan& scan = spin.scan;
  scan.stamp_s = stamp_s;
  scan.rows = lidar.rows();
  scan.columns = lidar.columns;
  scan.min_range_m = static_cast<float>(lidar.min_range_m);
  scan.max_range_m = static_cast<float>(lidar.max_range_m);
  std::vector<core::Pose> pose(static_cast<size_t>(lidar.columns));
  for (int column = 0; column < lidar.columns; ++column) {
    pose[static_cast<size_t>(column)] =
        T_map_lidar.At(stamp_s + column / (lidar.columns * lidar.spin_rate_hz));
  }
  for (int row = 0; row < lidar.rows(); ++row) {
    for (int column = 0; column < lidar.columns; ++column) {
      const core::Vec3 direction = lidar.Direction(row, column);
      const core::Pose& T = pose[static_cast<size_t>(column)];
      double range = world.Cast(T.translation(), T.linear() * direction);
      const bool hit = range <= lidar.max_range_m;
      if (hit && noise != nullptr) range += lidar.range_sigma_m * noise->Normal();
      const bool dropped = (noise != nullptr && noise->Uniform() < lidar.dropout_probability) ||
                           (hit && range < lidar.min_range_m);
      scan.direction_lidar.push_back(direction.cast<float>());
      scan.range_m.push_back(hit && !dropped ? static_cast<float>(range) : 0.0f);
      scan.time_s.push_back(static_cast<float>(column / (lidar.columns * lidar.spin_rate_hz)));
      scan.kind.push_back(dropped ? core::ReturnKind::kDropout
                          : hit   ? core::ReturnKind::kHit
                                  : core::ReturnKind::kVoid);
    }
  }
  return spin;
}

/// A LiDAR that stands still.
inline core::PoseTrajectory StandingAt(const core::Pose& T_map_lidar) {
  core::PoseTrajectory trajectory;
  trajectory.Add(0.0, T_map_lidar);
  return trajectory;
}

}  // namespace atlas::tests
