// LiDAR clouds as files hold them, in one type.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry.h"
#include "core/sensor_events.h"

namespace atlas::mapping {

/// One scan of a recorded log, in the LiDAR frame. Organised: point i = row * columns + column, and points
/// without a return are kept; else rows = 1 and columns = the number of points.
struct RecordedCloud {
  int rows = 0;
  int columns = 0;
  bool organised = false;
  std::vector<core::Vec3f> p_lidar;    ///< metres; NaN where there is none
  std::vector<float> time_s;           ///< a point each, after the stamp; empty when the file has none
  std::vector<core::ReturnKind> kind;  ///< a point each; empty when the file does not tell
  std::vector<uint16_t> ring;          ///< a point each; empty when the file has none
  std::optional<double> stamp_s;       ///< when the times in the file are absolute: of the first point
  core::Pose T_map_lidar = core::Pose::Identity();  ///< viewpoint (PCD); identity elsewhere

  size_t size() const { return p_lidar.size(); }
};

/// Reads a cloud by the content and the ending of its name: .pcd (0.7; ascii, binary, binary_compressed),
/// .ply (ascii, binary little and big endian) or .bin (KITTI: float32 x y z intensity).
///
/// Fields: x y z; optional time under t, time, time_s, time_stamp, timestamp, offset_time (seconds, milli-,
/// micro- or nanoseconds, told apart by their spread, since a scan lasts less than two seconds; absolute
/// where the first is more than two seconds from zero); ring; kind (0 hit, 1 void, 2 dropout). All zero and
/// infinite points become NaN. @throws InputError "FILE: reason" for whatever is not such a file; never
/// allocates more than the file's own size warrants.
RecordedCloud ReadCloud(const std::filesystem::path& path);
/// Whether `path` ends as a cloud file does.
bool HasCloudExtension(const std::filesystem::path& path);

/// The readers of file contents; `file` is the name used in errors.
RecordedCloud ParsePcd(std::string_view bytes, const std::string& file);
RecordedCloud ParsePlyCloud(std::string_view bytes, const std::string& file);
RecordedCloud ParseKittiBin(std::string_view bytes, const std::string& file);

}  // namespace atlas::mapping
