// What a run leaves for its video: the robot's states and what it knew and wanted at each scan.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry.h"
#include "sim/simulator.h"

namespace atlas::experiments {

/// The view that was chosen: where the robot goes next.
struct ChosenView {
  core::Vec2 p_map = core::Vec2::Zero();
  double yaw_rad = 0.0;
};

/// The map and the plan from `time_s` on, until the next keyframe.
struct VideoKeyframe {
  double time_s = 0.0;
  std::vector<core::Vec3f> occupied_map;  ///< voxel centres (OccupancyView::OccupiedCenters)
  std::vector<core::Vec2> path_map;       ///< planned; may be empty
  std::optional<ChosenView> view;
};

/// States every 20 to 100 ms of simulated time (Simulator::SetStateObserver), a keyframe after each sweep and
/// each plan; all by ascending time.
struct RunRecording {
  std::string scene;  ///< as LoadScene takes it
  std::string robot;  ///< as LoadRobot takes it
  double resolution_m = 0.05;
  std::vector<sim::Snapshot> states;
  std::vector<VideoKeyframe> keyframes;
};

/// Writes whole or not at all, about a tenth of a megabyte a minute. @throws InputError when that fails.
void SaveRecording(const std::filesystem::path& path, const RunRecording& recording);
/// @throws InputError for a file that is missing, cut short or of another kind.
RunRecording LoadRecording(const std::filesystem::path& path);

}  // namespace atlas::experiments
