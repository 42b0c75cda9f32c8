// A robot: its MJCF model, where the sensors sit, and what its gait can do.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/geometry.h"
#include "core/lidar_model.h"
#include "core/robot_extent.h"

namespace atlas::robots {

struct RobotSpec : core::RobotExtent {
  std::string name;
  std::string doc;
  std::filesystem::path mjcf;  ///< a model that stands alone (worldbody with the robot only)
  std::string lidar_model = "vlp16";
  core::Pose T_base_lidar = core::Pose::Identity();
  core::Pose T_base_depth = core::Pose::Identity();  ///< camera frame: x right, y down, z forward
  double max_speed_mps = 1.0;
  double max_step_m = 0.15;
  double max_slope_rad = 0.35;
};

struct CatalogEntry {
  std::string name;
  std::string doc;
  RobotSpec (*build)();
};
const std::vector<CatalogEntry>& Catalog();

/// A built-in robot by name, or "path/robot.xml" (an MJCF with the same body, joint and site names).
/// @throws InputError for an unknown name or a missing file.
RobotSpec LoadRobot(const std::string& name_or_path);

/// The LiDAR that carries the name; "robot": the robot's own. @throws InputError for an unknown name.
core::LidarModel LidarOf(const RobotSpec& robot, const std::string& name);

}  // namespace atlas::robots
