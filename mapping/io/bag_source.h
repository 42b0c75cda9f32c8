// ROS 1 bags as a source of scans and poses.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "mapping/io/scan_source.h"

namespace atlas::mapping {

/// "FILE.bag:/topic" apart; the topic is empty where none is named.
std::pair<std::string, std::string> SplitTopic(const std::string& text);
/// Whether `text` is FILE.bag or FILE.bag:/topic.
bool NamesBag(const std::string& text);

/// The sensor_msgs/PointCloud2 messages of `topic` (empty: the only such topic), by the time in their header
/// (by that of recording where it is zero). @throws InputError: no such topic, several to choose from (naming
/// them), a damaged bag.
std::unique_ptr<ScanSource> OpenBag(const std::filesystem::path& file, const std::string& topic);

/// The poses of a topic of nav_msgs/Odometry, nav_msgs/Path (the longest that it holds),
/// geometry_msgs/PoseStamped, PoseWithCovarianceStamped or TransformStamped messages (empty: the only such
/// topic), by the time in their header. Where they are those of another frame than `lidar_frame`, and the
/// bag's /tf_static leads from one to the other, they are carried over; RecordedPoses::note tells. @throws
/// InputError.
RecordedPoses ReadBagPoses(const std::filesystem::path& file, const std::string& topic,
                           const std::string& lidar_frame);

/// The topics that ReadBagPoses takes. @throws InputError for a damaged bag.
std::vector<std::string> PoseTopicsOf(const std::filesystem::path& file);

}  // namespace atlas::mapping
