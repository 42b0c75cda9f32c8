// Pose files of recorded logs.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry.h"
#include "core/sensor_events.h"

namespace atlas::mapping {

struct RecordedPoses {
  std::vector<double> time_s;  ///< ascending; empty when the file has no times
  std::vector<core::Pose> T_map_lidar;
  std::string note;  ///< what was made of them, for the user; mostly empty

  size_t size() const { return T_map_lidar.size(); }
  bool timed() const { return !time_s.empty(); }
};

/// Reads a pose file by the numbers in its rows (blanks or commas between, # begins a comment):
///   8   TUM: time tx ty tz qx qy qz qw
///   12  KITTI: the upper 3 x 4 of the matrix, no times
///   4   4 x 4 matrices, four rows each, no times
/// @throws InputError "FILE:LINE: field, value, limit" for a value that is not finite, a quaternion whose
/// length is not within 1 % of one, a matrix that is not a rotation within 1e-3, times that do not ascend, or
/// a file without poses.
RecordedPoses ReadPoses(const std::filesystem::path& path);
RecordedPoses ParsePoses(std::string_view text, const std::string& file);

/// The pose of a sensor calibration: a KITTI calib.txt (row `Tr:`, T_camera_lidar) or one pose as above
/// without a time (7 numbers tx ty tz qx qy qz qw, 12, or 4 x 4), T_posed_lidar: the LiDAR in the frame whose
/// poses were recorded.
struct Calibration {
  core::Pose T_posed_lidar = core::Pose::Identity();
  bool is_kitti = false;  ///< the poses are those of a camera; the map is the first LiDAR frame
};
Calibration ReadCalibration(const std::filesystem::path& path);
Calibration ParseCalibration(std::string_view text, const std::string& file);

/// T_map_lidar = T_map_posed * T_posed_lidar; for KITTI T_lidar0_camera0 * T_camera0_camera * T_camera_lidar.
void Apply(const Calibration& calibration, RecordedPoses* poses);

/// The pose at `time_s`: interpolated where a pose on either side is within `max_dt_s`, else the one that is,
/// else none. @pre timed.
std::optional<core::Pose> PoseNear(const RecordedPoses& poses, double time_s, double max_dt_s);

/// Writes "time tx ty tz qx qy qz qw" rows, whole or not at all.
void WriteTum(const std::filesystem::path& path, const std::vector<core::StampedPose>& poses);

}  // namespace atlas::mapping
