// The messages of ROS 1 bags that hold scans and poses.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mapping/io/recorded_cloud.h"
#include "mapping/io/recorded_poses.h"

namespace atlas::mapping {

/// std_msgs/Header, with which each of these messages begins.
struct BagHeader {
  double stamp_s = 0.0;
  std::string frame;
};
/// What of a message's bytes is enough for ParseBagHeader, with a frame's name of ordinary length.
constexpr size_t kBagHeaderBytes = 256;
/// @throws InputError "WHERE: reason"; so do the others.
BagHeader ParseBagHeader(std::string_view bytes, const std::string& where);

constexpr std::string_view kCloudType = "sensor_msgs/PointCloud2";
/// Fields as of ReadCloud; x y z of either precision, either byte order. Organised where the height is
/// above 1.
RecordedCloud ParseCloudMessage(std::string_view bytes, const std::string& where);

/// nav_msgs/Odometry, geometry_msgs/PoseStamped, PoseWithCovarianceStamped, TransformStamped: one pose.
/// nav_msgs/Path: all that the message holds.
bool IsPoseType(std::string_view type);
struct BagPose {
  double stamp_s = 0.0;
  core::Pose pose = core::Pose::Identity();
  std::string frame, child_frame;  ///< the child's is empty where the type has none
};
std::vector<BagPose> ParsePoseMessage(std::string_view type, std::string_view bytes,
                                      const std::string& where);

/// tf2_msgs/TFMessage, as of the topics /tf and /tf_static.
bool IsTransformsType(std::string_view type);
std::vector<BagPose> ParseTransformsMessage(std::string_view bytes, const std::string& where);

}  // namespace atlas::mapping
