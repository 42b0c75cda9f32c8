#include "planner/gain/sweep_view.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace atlas::planner {
namespace {

/// Times of the sweep at which the beams are laid over a direction: the roll turns by less than half a
/// VLP-16's beam spacing from one to the next.
constexpr int kTimeSteps = 321;

core::Vec3 DirectionOf(double azimuth_rad, double elevation_rad) {
  return {std::cos(elevation_rad) * std::cos(azimuth_rad), std::cos(elevation_rad) * std::sin(azimuth_rad),
          std::sin(elevation_rad)};
}

double ElevationOf(const core::Vec3& direction) {
  return std::asin(std::clamp(direction.z(), -1.0, 1.0));
}

core::Mat3 RollBack(double roll_rad) {
  return Eigen::AngleAxisd(-roll_rad, core::Vec3::UnitX()).toRotationMatrix();
}

}  // namespace

SweepView::SweepView(const SweepSensorModel& sensor)
    : R_lidar_base_(sensor.T_base_lidar.linear().transpose()),
      roll_rad_(sensor.roll.amplitude_rad()),
      sensor_height_m_(sensor.base_height_m + sensor.T_base_lidar.translation().z()),
      beam_rad_(sensor.lidar.elevation_rad) {
  assert(beam_rad_.size() >= 2);
  std::sort(beam_rad_.begin(), beam_rad_.end());
  // A beam's rays are spread over the elevations nearest to it; those of the outermost ones stay within them.
  const auto beams = static_cast<double>(beam_rad_.size());
  edge_sine_.push_back(std::sin(beam_rad_.front()));
  double low = beam_rad_.front();
  for (size_t i = 0; i < beam_rad_.size(); ++i) {
    const bool last = i + 1 == beam_rad_.size();
    const double high = last ? beam_rad_.back() : 0.5 * (beam_rad_[i] + beam_rad_[i + 1]);
    beam_share_.push_back(1.0 / (std::max(high - low, 1e-6) * beams));
    edge_sine_.push_back(std::sin(high));
    low = high;
  }
  for (int i = 0; i < kTimeSteps; ++i) {
    const double roll = sensor.roll.At((i + 0.5) / kTimeSteps * sensor.roll.period_s()).roll_rad;
    roll_cos_sin_.emplace_back(std::cos(roll), std::sin(roll));
  }
  FillTable(static_cast<double>(sensor.lidar.rows()) * sensor.lidar.columns * sensor.lidar.spin_rate_hz *
            sensor.roll.period_s());
  FindExtents();
}

/// Mean over the time of the sweep of the share of rays per steradian: beams are uniform in azimuth about the
/// LiDAR's axis, so a share per radian of elevation spreads over 2 pi cos(elevation) radians.
double SweepView::DensityAt(const core::Vec3& direction_base) const {
  const core::Vec3 axis_base = R_lidar_base_.row(2).transpose();
  const double constant = axis_base.x() * direction_base.x();
  const double cosine = axis_base.dot(direction_base) - constant;
  const double sine = axis_base.dot(core::Vec3::UnitX().cross(direction_base));
  double sum = 0.0;
  for (const core::Vec2& roll : roll_cos_sin_) {
    const double z = constant + roll.x() * cosine - roll.y() * sine;  // sine of the elevation in the LiDAR
    if (z < edge_sine_.front() || z > edge_sine_.back()) continue;
    size_t beam = 0;
    while (beam + 1 < beam_share_.size() && z > edge_sine_[beam + 1]) ++beam;
    sum += beam_share_[beam] / (2.0 * core::kPi * std::sqrt(std::max(1.0 - z * z, 1e-6)));
  }
  return sum / static_cast<double>(roll_cos_sin_.size());
}

void SweepView::FillTable(double rays_in_sweep) {
  table_.resize(static_cast<size_t>(kAzimuthCells) * kElevationCells);
  for (int row = 0; row < kElevationCells; ++row) {
    const double elevation = (row + 0.5) * core::kPi / kElevationCells - 0.5 * core::kPi;
    for (int column = 0; column < kAzimuthCells; ++column) {
      const double azimuth = (column + 0.5) * 2.0 * core::kPi / kAzimuthCells;
      table_[static_cast<size_t>(row) * kAzimuthCells + static_cast<size_t>(column)] =
          rays_in_sweep * DensityAt(DirectionOf(azimuth, elevation));
    }
  }
}

/// The elevation seen by the LiDAR is continuous in the roll, so the interval that it covers while rolling
/// meets the beams' interval exactly when the direction is seen. Its extremes lie at the ends of the roll or
/// where the direction passes through the highest or lowest point of its circle about the roll axis.
bool SweepView::Sees(const core::Vec3& direction_base) const {
  const core::Vec3 axis_base = R_lidar_base_.row(2).transpose();  // the LiDAR's axis in the base frame
  const double turn_rad = std::atan2(axis_base.dot(core::Vec3::UnitX().cross(direction_base)),
                                     axis_base.dot(direction_base) - axis_base.x() * direction_base.x());
  double low = core::kPi, high = -core::kPi;
  const auto include = [&](double roll) {
    const double e = ElevationOf(R_lidar_base_ * (RollBack(roll) * direction_base));
    low = std::min(low, e);
    high = std::max(high, e);
  };
  include(-roll_rad_);
  include(roll_rad_);
  for (const double extreme : {-turn_rad, core::kPi - turn_rad}) {
    // axis . R_x(-roll) d = constant + amplitude * cos(roll + turn): extreme where the cosine is.
    const double roll = core::WrapAngle(extreme);
    if (std::abs(roll) <= roll_rad_) include(roll);
  }
  return high >= beam_rad_.front() && low <= beam_rad_.back();
}

void SweepView::FindExtents() {
  constexpr int kAzimuths = 72;
  constexpr double kStep_rad = core::Radians(0.1);
  common_min_rad_ = -0.5 * core::kPi;
  common_max_rad_ = 0.5 * core::kPi;
  for (int i = 0; i < kAzimuths; ++i) {
    const double azimuth = 2.0 * core::kPi * i / kAzimuths;
    double up = 0.0, down = 0.0;
    while (up < 0.5 * core::kPi && Sees(DirectionOf(azimuth, up))) up += kStep_rad;
    while (down > -0.5 * core::kPi && Sees(DirectionOf(azimuth, down))) down -= kStep_rad;
    common_max_rad_ = std::min(common_max_rad_, up);
    common_min_rad_ = std::max(common_min_rad_, down);
    max_rad_ = std::max(max_rad_, up);
    min_rad_ = std::min(min_rad_, down);
  }
}

}  // namespace atlas::planner
