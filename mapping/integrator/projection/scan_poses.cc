#include <algorithm>
#include <cmath>

#include "mapping/integrator/projection/scan_poses.h"

namespace atlas::mapping {
namespace {

constexpr double kStillRad = 1e-4, kStillM = 1e-3;
constexpr float kSharedTimeS = 2e-4f;
/// Columns from one pose to the next that is asked for: half a millisecond of a revolution.
constexpr size_t kStride = 4;

double AngleOf(const core::Mat3& R) {
  return Eigen::AngleAxisd(R).angle();
}

bool RowsShareTimes(const core::LidarScan& scan) {
  const auto columns = static_cast<size_t>(scan.columns);
  for (size_t row = columns; row < scan.time_s.size(); row += columns) {
    int apart = 0;
    for (size_t i = row; i < row + columns; ++i) {
      apart += !(std::abs(scan.time_s[i] - scan.time_s[i - columns]) < kSharedTimeS);
    }
    if (apart > 0) return false;
  }
  return true;
}

/// The first and the last time, by lanes that compilers turn into vectors.
std::pair<float, float> TimesOf(const std::vector<float>& times) {
  constexpr size_t kLanes = 16;
  std::array<float, kLanes> first, last;
  first.fill(times.front());
  last.fill(times.front());
  size_t i = 0;
  for (; i + kLanes <= times.size(); i += kLanes) {
    for (size_t k = 0; k < kLanes; ++k) {
      first[k] = std::min(first[k], times[i + k]);
      last[k] = std::max(last[k], times[i + k]);
    }
  }
  for (; i < times.size(); ++i) {
    first[0] = std::min(first[0], times[i]);
    last[0] = std::max(last[0], times[i]);
  }
  return {*std::min_element(first.begin(), first.end()), *std::max_element(last.begin(), last.end())};
}

void SetPose(size_t i, const core::Pose& T, ColumnPoses* out) {
  for (size_t row = 0; row < 3; ++row) {
    for (size_t column = 0; column < 4; ++column) {
      out->T_mid_lidar[4 * row + column][i] =
          static_cast<float>(T.matrix()(static_cast<int>(row), static_cast<int>(column)));
    }
  }
}

/// The columns between two, straight from entry to entry by their times.
template <typename TimeOf>
void Interpolate(size_t first, size_t last, const TimeOf& time_of, ColumnPoses* out) {
  const double span_s = time_of(last) - time_of(first);
  for (size_t column = first + 1; column < last; ++column) {
    const auto w = static_cast<float>(span_s != 0.0 ? (time_of(column) - time_of(first)) / span_s : 0.0);
    for (std::vector<float>& entry : out->T_mid_lidar) {
      entry[column] = entry[first] + w * (entry[last] - entry[first]);
    }
  }
}

}  // namespace

void PosesOfScan(const core::SpinEvent& spin, bool motion_aware, ColumnPoses* poses) {
  ColumnPoses& out = *poses;
  out.moving = false;
  out.pose_of_ray.clear();
  const core::LidarScan& scan = spin.scan;
  const auto columns = static_cast<size_t>(scan.columns);
  if (scan.time_s.empty()) {
    out.T_odom_mid = spin.T_odom_lidar.At(scan.stamp_s);
    return;
  }
  const auto [first_s, last_s] = TimesOf(scan.time_s);
  const double begin_s = scan.stamp_s + static_cast<double>(first_s);
  const double span_s = static_cast<double>(last_s) - static_cast<double>(first_s);
  out.T_odom_mid = spin.T_odom_lidar.At(begin_s + 0.5 * span_s);
  if (!motion_aware) return;

  const bool shared = RowsShareTimes(scan);
  const core::Pose T_mid_odom = out.T_odom_mid.inverse();
  for (auto& entry : out.T_mid_lidar) entry.resize(columns);
  const auto time_of = [&](size_t column) {
    return shared ? scan.stamp_s + static_cast<double>(scan.time_s[column])
                  : begin_s + span_s * static_cast<double>(column) / static_cast<double>(columns - 1);
  };
  size_t before = 0;
  for (size_t column = 0; column < columns; column = std::min(column + kStride, columns - 1)) {
    const core::Pose T = T_mid_odom * spin.T_odom_lidar.At(time_of(column));
    out.moving = out.moving || AngleOf(T.linear()) > kStillRad || T.translation().norm() > kStillM;
    SetPose(column, T, &out);
    Interpolate(before, column, time_of, &out);
    before = column;
    if (column + 1 == columns) break;
  }
  if (out.moving && !shared) {
    out.pose_of_ray.resize(scan.time_s.size());
    const float scale = span_s > 0.0 ? static_cast<float>(static_cast<double>(columns - 1) / span_s) : 0.0f;
    for (size_t i = 0; i < scan.time_s.size(); ++i) {
      out.pose_of_ray[i] = static_cast<int32_t>((scan.time_s[i] - first_s) * scale + 0.5f);
    }
  }
}

}  // namespace atlas::mapping
