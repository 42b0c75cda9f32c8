// ROS 1 bags as a source of scans and poses, where the build has the library that reads them.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "mapping/io/scan_source.h"

namespace atlas::mapping {

/// Whether this build reads bags.
bool HasBagSupport();

/// The sensor_msgs/PointCloud2 messages of `topic` (empty: the only such topic). @throws InputError: no such
/// topic, several to choose from (naming them), a damaged bag, a build without bag support.
std::unique_ptr<ScanSource> OpenBag(const std::filesystem::path& file, const std::string& topic);

/// The poses of a topic of nav_msgs/Odometry, geometry_msgs/PoseStamped, PoseWithCovarianceStamped or
/// TransformStamped messages, by the time in their header. @throws InputError.
RecordedPoses ReadBagPoses(const std::filesystem::path& file, const std::string& topic);

}  // namespace atlas::mapping
