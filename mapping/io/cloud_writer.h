// Clouds and scans into files that ReadCloud reads back.
#pragma once

#include <filesystem>
#include <string>

#include "core/sensor_events.h"
#include "mapping/io/recorded_cloud.h"

namespace atlas::mapping {

/// Organised binary PCD of a scan: x y z float32 (LiDAR frame at the ray's own time, NaN where no return), t
/// float32 seconds after the stamp, kind uint8 (0 hit, 1 void, 2 dropout).
std::string ScanToPcd(const core::LidarScan& scan);
/// "1583840211.123456789.pcd": the name by which a scan meets its pose.
std::string ScanFileName(double stamp_s);
/// Writes `folder`/scans/<stamp>.pcd, whole or not at all. @throws InputError when that fails.
void WriteScan(const std::filesystem::path& folder, const core::LidarScan& scan);

enum class CloudEncoding { kAscii, kBinary, kBinaryCompressed };
/// PCD with x y z, and t (seconds), kind and ring where the cloud has them; kBinaryCompressed by LZF.
std::string CloudToPcd(const RecordedCloud& cloud, CloudEncoding encoding);
/// PLY with the same; ascii or binary little endian (kBinaryCompressed is not of PLY: taken as kBinary).
std::string CloudToPly(const RecordedCloud& cloud, CloudEncoding encoding);

}  // namespace atlas::mapping
