// Points, poses, boxes and rays. Right-handed, z up, metres, radians, seconds.
//
// Frames stand in names: `T_map_base` takes base points to map; `p_map` is a point in map; adjacent names
// cancel (`p_map = T_map_base * p_base`).
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace atlas::core {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Vec3f = Eigen::Vector3f;
using Mat3 = Eigen::Matrix3d;
using Pose = Eigen::Isometry3d;

constexpr double kPi = 3.14159265358979323846;
constexpr double Radians(double degrees) {
  return degrees * (kPi / 180.0);
}
constexpr double Degrees(double radians) {
  return radians * (180.0 / kPi);
}

/// `angle_rad` wrapped to [-pi, pi].
inline double WrapAngle(double angle_rad) {
  return std::remainder(angle_rad, 2.0 * kPi);
}

/// Rotation by yaw (z), then pitch (y), then roll (x), in the intrinsic order.
inline Mat3 RotationFromYawPitchRoll(double yaw_rad, double pitch_rad, double roll_rad) {
  return (Eigen::AngleAxisd(yaw_rad, Vec3::UnitZ()) * Eigen::AngleAxisd(pitch_rad, Vec3::UnitY()) *
          Eigen::AngleAxisd(roll_rad, Vec3::UnitX()))
      .toRotationMatrix();
}

inline double YawOf(const Mat3& R) {
  return std::atan2(R(1, 0), R(0, 0));
}

inline Pose MakePose(const Mat3& R, const Vec3& t) {
  Pose T = Pose::Identity();
  T.linear() = R;
  T.translation() = t;
  return T;
}

/// A pose standing upright at `p` with heading `yaw_rad`.
inline Pose PoseFromXyzYaw(const Vec3& p, double yaw_rad) {
  return MakePose(RotationFromYawPitchRoll(yaw_rad, 0.0, 0.0), p);
}

/// Geodesic interpolation, u in [0, 1].
Pose Interpolate(const Pose& a, const Pose& b, double u);

/// Axis-aligned box, closed on both sides. Empty while min > max.
struct Box3 {
  Vec3 min = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 max = Vec3::Constant(-std::numeric_limits<double>::infinity());

  bool Empty() const { return (min.array() > max.array()).any(); }
  bool Contains(const Vec3& p) const {
    return (p.array() >= min.array()).all() && (p.array() <= max.array()).all();
  }
  Vec3 Size() const { return max - min; }
  Vec3 Center() const { return 0.5 * (min + max); }
  void Extend(const Vec3& p) {
    min = min.cwiseMin(p);
    max = max.cwiseMax(p);
  }
  Box3 Inflated(double margin) const { return {min.array() - margin, max.array() + margin}; }
  double DistanceTo(const Vec3& p) const { return (p - p.cwiseMax(min).cwiseMin(max)).norm(); }

  /// The interval of t >= 0 for which origin + t * direction lies inside, if any.
  std::optional<std::pair<double, double>> Clip(const Vec3& origin, const Vec3& direction) const;
};

struct Ray {
  Vec3f origin;
  Vec3f direction;  ///< unit length
};

}  // namespace atlas::core
