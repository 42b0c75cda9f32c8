#include "experiments/video/follow_camera.h"

namespace atlas::experiments {
namespace {

constexpr double kFovRad = core::Radians(46.0);
constexpr double kBearingOffsetRad = core::Radians(32.0);  ///< to the side, so that the robot hides nothing
constexpr double kTurnTimeS = 3.0, kMoveTimeS = 1.2;
constexpr double kElevationRad = core::Radians(26.0);
constexpr double kMinDistanceM = 4.5, kMaxDistanceM = 16.0;
constexpr double kWallMarginM = 0.35;
constexpr double kHeadM = 0.35;  ///< above the base: where rays to the camera start

}  // namespace

FollowCamera::FollowCamera(const scenes::SceneSpec& spec, const sim::Raycaster& scene)
    : scene_(scene),
      object_center_(spec.object_box.Empty() ? core::Vec3(0, 0, 0) : spec.object_box.Center()),
      object_radius_m_(spec.object_box.Empty() ? 0.0 : 0.5 * spec.object_box.Size().head<2>().norm()) {}

/// As far towards `eye` as nothing stands between.
core::Vec3 FollowCamera::FreeEye(const core::Vec3& from, const core::Vec3& eye) const {
  const core::Vec3 direction = (eye - from).normalized();
  const double distance = (eye - from).norm();
  const core::Ray ray{from.cast<float>(), direction.cast<float>()};
  sim::RayHit hit;
  scene_.CastStatic({&ray, 1}, static_cast<float>(distance + kWallMarginM), 1, {&hit, 1});
  if (hit.range_m < 0.0f) return eye;
  return from + std::max(hit.range_m - kWallMarginM, 0.3 * hit.range_m) * direction;
}

sim::RenderCamera FollowCamera::Advance(const core::Vec3& p_base_map, double dt_s) {
  const core::Vec3 head = p_base_map + kHeadM * core::Vec3::UnitZ();
  // Inside the object (a house, a mine) the robot itself is what matters.
  const core::Vec3 to_robot = p_base_map - object_center_;
  const double separation = to_robot.head<2>().norm();
  const double outside = std::clamp(separation / std::max(object_radius_m_, 1.0) - 0.4, 0.0, 1.0);

  const double wanted_bearing = std::atan2(to_robot.y(), to_robot.x()) + kBearingOffsetRad;
  if (!started_) bearing_rad_ = wanted_bearing;
  bearing_rad_ += core::WrapAngle(wanted_bearing - bearing_rad_) * (1.0 - std::exp(-dt_s / kTurnTimeS));

  const core::Vec3 focus =
      head + outside * core::Vec3(-0.35 * to_robot.x(), -0.35 * to_robot.y(), 0.06 * separation);
  const double distance =
      std::clamp(kMinDistanceM + 0.55 * outside * separation, kMinDistanceM, kMaxDistanceM);
  const core::Vec3 back(std::cos(bearing_rad_) * std::cos(kElevationRad),
                        std::sin(bearing_rad_) * std::cos(kElevationRad), std::sin(kElevationRad));
  const core::Vec3 wanted_eye = FreeEye(head, head + distance * back);

  const double share = started_ ? 1.0 - std::exp(-dt_s / kMoveTimeS) : 1.0;
  eye_ += share * (wanted_eye - eye_);
  target_ += share * (focus - target_);
  started_ = true;
  sim::RenderCamera camera;
  camera.T_map_camera = sim::LookAt(FreeEye(head, eye_), target_);
  camera.vertical_fov_rad = kFovRad;
  return camera;
}

}  // namespace atlas::experiments
