#include "mapping/terrain/ray_ingest.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace atlas::mapping::terrain {
namespace {

constexpr float kKeepBelow_m = 4.0f, kKeepAbove_m = 2.5f;
/// More than the robot is tall. What a rising ray meets farther above the ground expected there is a ceiling,
/// or a wall's upper part: in nobody's way, and no ground, though a slab is thin enough for its underside to
/// be taken for its upper side.
constexpr float kOverhead_m = 1.0f;
constexpr double kSamePose_s = 1e-3;    ///< rays this close in time share a pose
constexpr float kRangeSigma_m = 0.01f;  ///< along a LiDAR's ray
constexpr float kAttitudeSigma_rad = 0.002f;
constexpr float kHeightSigma_m = 0.004f;  ///< of the sensor itself
constexpr float kTrustedVoid_m = 12.0f;   ///< a void ray proves no more than this of free space
constexpr float kSurfaceSlack_m = 0.05f;  ///< a ray this far under the expected height has crossed it ...
constexpr float kClearDrop_m = 0.12f;     ///< ... if it goes on at least to here
constexpr int kHeadroomAzimuths = 225;    ///< firings a revolution whose free space is kept
constexpr int kHeadroomRows = 32;
constexpr int kDepthStride = 2;  ///< pixels, both ways
constexpr float kMaxDepth_m = 4.0f;

float Square(float x) {
  return x * x;
}

/// Of a height read off a ray with this steepness (vertical share of its unit direction) and length.
float LidarVariance(float steepness, float range_m) {
  return Square(kRangeSigma_m * steepness) + Square(kAttitudeSigma_rad * range_m) + Square(kHeightSigma_m);
}

/// Stereo depth grows uncertain with the square of the distance.
float DepthVariance(float depth_m) {
  return Square(0.005f + 0.003f * Square(depth_m)) + Square(kHeightSigma_m);
}

struct PoseF {
  Eigen::Matrix3f R;
  core::Vec3f t;
  explicit PoseF(const core::Pose& T) : R(T.linear().cast<float>()), t(T.translation().cast<float>()) {}
};

}  // namespace

void RayIngest::AddReturn(const core::Vec3f& p_odom, const core::Vec3f& direction, float variance_m2) {
  if (!(p_odom.z() > ground_m_ - kKeepBelow_m && p_odom.z() < ground_m_ + kKeepAbove_m)) return;
  const int ix = grid_.IndexOf(p_odom.x()), iy = grid_.IndexOf(p_odom.y());
  if (!grid_.Contains(ix, iy)) return;
  const size_t slot = grid_.Slot(ix, iy);
  if (direction.z() > 0.0f && p_odom.z() > grid_.reference_m(slot) + kOverhead_m) return;
  grid_.AddHeight(slot, p_odom.z(), variance_m2);
}

void RayIngest::AddClearRay(const core::Vec3f& origin, const core::Vec3f& direction, float clear_m) {
  if (direction.z() > -0.02f || origin.z() + direction.z() * clear_m > ground_m_ - kClearDrop_m) return;
  // The expected height is that of the cell where the ray crosses it: found by trying the robot's first.
  float expected = ground_m_;
  size_t slot = 0;
  for (int round = 0; round < 3; ++round) {
    const float t = (origin.z() - (expected - kSurfaceSlack_m)) / -direction.z();
    if (t <= 0.0f || t >= clear_m) return;
    const int ix = grid_.IndexOf(origin.x() + t * direction.x()),
              iy = grid_.IndexOf(origin.y() + t * direction.y());
    if (!grid_.Contains(ix, iy)) return;
    slot = grid_.Slot(ix, iy);
    const float reference = grid_.reference_m(slot);
    if (std::isnan(reference) || std::abs(reference - expected) < 0.01f) break;
    expected = reference;
  }
  if (origin.z() + direction.z() * clear_m < expected - kClearDrop_m) grid_.AddCrossing(slot);
}

void RayIngest::AddSpin(const core::SpinEvent& spin) {
  const core::LidarScan& scan = spin.scan;
  if (spin.T_odom_lidar.empty()) return;
  const int column_stride = std::max(1, scan.columns / kHeadroomAzimuths);
  const int row_stride = std::max(1, scan.rows / kHeadroomRows);
  for (int column = 0; column < scan.columns; ++column) {
    double pose_time = std::numeric_limits<double>::quiet_NaN();
    PoseF T(core::Pose::Identity());
    for (int row = 0; row < scan.rows; ++row) {
      const size_t i =
          static_cast<size_t>(row) * static_cast<size_t>(scan.columns) + static_cast<size_t>(column);
      const core::ReturnKind kind = scan.kind[i];
      if (kind == core::ReturnKind::kDropout) continue;
      const double time = static_cast<double>(scan.time_s[i]);
      if (!(std::abs(time - pose_time) <= kSamePose_s)) {
        pose_time = time;
        T = PoseF(spin.T_odom_lidar.At(scan.stamp_s + time));
      }
      const core::Vec3f direction = T.R * scan.direction_lidar[i];
      const float clear = kind == core::ReturnKind::kHit ? scan.range_m[i] : kTrustedVoid_m;
      AddClearRay(T.t, direction, clear);
      if (column % column_stride == 0 && row % row_stride == 0) headroom_.AddClearRay(T.t, direction, clear);
      if (kind == core::ReturnKind::kHit)
        AddReturn(T.t + clear * direction, direction, LidarVariance(direction.z(), clear));
    }
  }
}

void RayIngest::AddDepth(const core::DepthEvent& event, const core::Pose& T_odom_base,
                         const core::Vec2& half_footprint_m) {
  const core::DepthImage& image = event.image;
  if (!(image.focal_px > 0.0)) return;
  const PoseF T(event.T_odom_camera);
  const PoseF T_base_odom(T_odom_base.inverse());
  const float inverse_focal = static_cast<float>(1.0 / image.focal_px);
  const Eigen::Vector2f half = (half_footprint_m + core::Vec2::Constant(0.05)).cast<float>();
  for (int v = 0; v < image.height; v += kDepthStride) {
    for (int u = 0; u < image.width; u += kDepthStride) {
      const float depth =
          image.depth_m[static_cast<size_t>(v) * static_cast<size_t>(image.width) + static_cast<size_t>(u)];
      if (!(depth > 0.05f && depth < kMaxDepth_m)) continue;
      const core::Vec3f ray(
          (static_cast<float>(u) + 0.5f - 0.5f * static_cast<float>(image.width)) * inverse_focal,
          (static_cast<float>(v) + 0.5f - 0.5f * static_cast<float>(image.height)) * inverse_focal, 1.0f);
      const core::Vec3f reach = T.R * (depth * ray);
      const core::Vec3f p_odom = T.t + reach, p_base = T_base_odom.R * p_odom + T_base_odom.t;
      const bool on_robot = std::abs(p_base.x()) < half.x() && std::abs(p_base.y()) < half.y() &&
                            p_odom.z() > ground_m_ + 0.05f;
      if (on_robot) continue;
      const float length = reach.norm();
      AddClearRay(T.t, reach / length, length);
      AddReturn(p_odom, reach, DepthVariance(depth));
    }
  }
}

void RayIngest::AddFoot(const core::Vec3& p_odom, double sigma_m) {
  const float variance = static_cast<float>(sigma_m * sigma_m);
  const int ix = grid_.IndexOf(p_odom.x()), iy = grid_.IndexOf(p_odom.y());
  constexpr int kReturns = 2;  // enough to count as support by itself
  if (grid_.Contains(ix, iy))
    grid_.AddHeight(grid_.Slot(ix, iy), static_cast<float>(p_odom.z()), variance, kReturns);
}

}  // namespace atlas::mapping::terrain
