// Drift of LiDAR odometry over windows of 10 and 100 m (KITTI's measure), beside its prior's.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/sensor_events.h"

namespace atlas::experiments {

/// Error of relative poses over all windows of a length, and how many there are.
struct WindowDrift {
  double length_m = 0.0;
  size_t windows = 0;
  double percent = 0.0;    ///< mean translation error, of the length
  double deg_per_m = 0.0;  ///< mean rotation error
};
/// A window begins at each `stride`-th pose, and ends with the first pose `length_m` of true way on.
/// @pre equally many poses.
WindowDrift DriftOver(double length_m, const std::vector<core::Pose>& truth,
                      const std::vector<core::Pose>& estimate, size_t stride);

struct OdometryCase {
  std::string scene, lidar;
  std::string prior;  ///< "biased" (SLAM model: white noise of 2 cm and 0.1 degree per 2 m, 1 % too long,
                      ///< 0.05 degrees a second of yaw) or "none"
  double way_m = 0.0;
  size_t scans = 0, lost = 0, degenerate = 0;
  double ms_a_scan = 0.0;
  double end_error_m = 0.0;
  std::vector<WindowDrift> drift, prior_drift;  ///< of 10 and 100 m; the second empty without a prior
};

/// Along the scene's own route at 10 Hz, `max_scans` of it (0: all), one thread. Repeats exactly, times
/// aside.
OdometryCase RunOdometryCase(const std::string& scene, const std::string& lidar, bool with_prior,
                             int max_scans, int threads, const std::function<void(double)>& progress);

std::string OdometryTable(const std::vector<OdometryCase>& cases);
/// odometry.md and odometry.csv.
void WriteOdometryBench(const std::filesystem::path& folder, const std::vector<OdometryCase>& cases);

}  // namespace atlas::experiments
