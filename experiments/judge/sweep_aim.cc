#include "experiments/judge/sweep_aim.h"

#include <cassert>
#include <cmath>

namespace atlas::experiments {

using core::Mat3;
using core::Vec3;
using core::Vec3f;

SweepAim::SweepAim(const robots::RobotSpec& robot, const core::LidarModel& lidar, int headings,
                   double max_roll_rad)
    : T_base_lidar_(robot.T_base_lidar),
      stance_m_(robot.stance_height_m),
      sensor_height_m_(robot.stance_height_m + robot.T_base_lidar.translation().z()),
      sensor_reach_m_(robot.T_base_lidar.translation().norm()),
      heading_step_rad_(2.0 * core::kPi / headings),
      max_roll_rad_(max_roll_rad) {
  assert(headings >= 1 && !lidar.elevation_rad.empty());
  const auto [lo, hi] = std::minmax_element(lidar.elevation_rad.begin(), lidar.elevation_rad.end());
  lowest_rad_ = *lo;
  highest_rad_ = *hi;
}

bool SweepAim::At(const Vec3& ground_map, const Vec3f& target_map, int variant, Shot* shot) const {
  const Vec3 base = ground_map + Vec3(0.0, 0.0, stance_m_);
  const Vec3 target = target_map.cast<double>();
  // The heading with the target most nearly abeam on the left.
  const double azimuth = std::atan2(target.y() - base.y(), target.x() - base.x());
  const double heading = std::round((azimuth - 0.5 * core::kPi) / heading_step_rad_) * heading_step_rad_;
  const double c = std::cos(heading), s = std::sin(heading);
  const auto to_base = [&](const Vec3& v) {
    return Vec3(c * v.x() + s * v.y(), -s * v.x() + c * v.y(), v.z());
  };
  const auto to_map = [&](const Vec3& v) {
    return Vec3(c * v.x() - s * v.y(), s * v.x() + c * v.y(), v.z());
  };

  // Rolling by phi lifts the left: the target's elevation about the nose axis, seen from the rolled sensor,
  // is what is left of atan2(z, y). One round of correction for the sensor's own motion suffices: the beams
  // are wide.
  const double aside = variant == 0 ? 0.0 : (variant == 1 ? -0.8 : 0.8) * 0.5 * (highest_rad_ - lowest_rad_);
  const Vec3 target_base = to_base(target - base);
  double roll = 0.0;
  Vec3 origin_base = T_base_lidar_.translation();
  for (int round = 0; round < 2; ++round) {
    const Vec3 d = target_base - origin_base;
    const double middle = 0.5 * (highest_rad_ + lowest_rad_);
    roll = std::clamp(std::atan2(d.z(), d.y()) - middle + aside, -max_roll_rad_, max_roll_rad_);
    origin_base = Eigen::AngleAxisd(roll, Vec3::UnitX()) * T_base_lidar_.translation();
  }
  const Vec3 d_base = target_base - origin_base;
  const double distance = d_base.norm();
  if (!(distance > 1e-6)) return false;
  const Vec3 d_lidar =
      T_base_lidar_.linear().transpose() * (Eigen::AngleAxisd(-roll, Vec3::UnitX()) * d_base);
  const double elevation = std::asin(std::clamp(d_lidar.z() / distance, -1.0, 1.0));
  if (elevation < lowest_rad_ || elevation > highest_rad_) return false;
  shot->origin = (base + to_map(origin_base)).cast<float>();
  shot->direction = to_map(d_base / distance).cast<float>();
  shot->distance_m = static_cast<float>(distance);
  return true;
}

double SweepAim::RaysPerSteradian(const core::LidarModel& lidar, int headings, double period_s) const {
  const double rays = headings * period_s * lidar.spin_rate_hz * lidar.columns * lidar.rows();
  const double top = std::min(0.5 * core::kPi, highest_rad_ + max_roll_rad_);
  const double bottom = std::max(-0.5 * core::kPi, lowest_rad_ - max_roll_rad_);
  return rays / (2.0 * core::kPi * (std::sin(top) - std::sin(bottom)));
}

}  // namespace atlas::experiments
