// Where the scans of a log come from: files of a folder, a scan graph, a bag.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mapping/io/recorded_cloud.h"
#include "mapping/io/recorded_poses.h"

namespace atlas::mapping {

struct ScanEntry {
  std::string name;
  std::optional<double> stamp_s;          ///< by its name, or as recorded
  std::optional<core::Pose> T_map_lidar;  ///< where the source itself tells
};

class ScanSource {
 public:
  virtual ~ScanSource() = default;
  const std::vector<ScanEntry>& entries() const { return entries_; }
  /// "4 x PCD in DIR", "scan graph FILE": for messages.
  const std::string& description() const { return description_; }
  /// Whence entries have their poses: "viewpoints", "the graph".
  const std::string& pose_origin() const { return pose_origin_; }
  /// The frame that the points are in, where the source names it.
  const std::string& frame() const { return frame_; }
  /// @throws InputError naming the file.
  virtual RecordedCloud Read(size_t index) const = 0;

 protected:
  std::vector<ScanEntry> entries_;
  std::string description_, pose_origin_, frame_;
};

/// Opens what RecordedLogOptions::scans names (data set folders are resolved before). @throws InputError.
std::unique_ptr<ScanSource> OpenScans(const std::string& scans);

/// The time in a file's name without its ending: seconds with a decimal fraction ("1583840211.1234"), seconds
/// and nanoseconds ("cloud_1583840211_000000012"), or a whole number that ends the name, of 10 (seconds), 13
/// (ms), 16 (us) or 19 (ns) digits. None for an ordinary count ("000012").
std::optional<double> TimeInName(std::string_view stem);
/// "scan9" before "scan10".
bool NaturalLess(std::string_view a, std::string_view b);

/// The VIEWPOINT of a PCD file. @throws InputError for a header that is none.
core::Pose ViewpointOf(const std::filesystem::path& path);

/// Poses of clouds in `folder` from files T_<A>_<B>.txt there, each the pose of frame B in frame A, where
/// frames are stems of `clouds` or "map"/"world". The map is the frame that is nobody's B. Nothing where
/// there are no such files. @throws InputError when they do not reach every cloud.
std::vector<core::Pose> PosesFromRelations(const std::filesystem::path& folder,
                                           const std::vector<std::string>& stems);

}  // namespace atlas::mapping
