// Which pose belongs to which scan.
#pragma once

#include <string>
#include <vector>

#include "mapping/io/recorded_poses.h"
#include "mapping/io/scan_source.h"

namespace atlas::mapping {

struct MatchedScan {
  size_t source_index = 0;
  double stamp_s = 0.0;
  core::Pose T_map_lidar = core::Pose::Identity();
};

struct PoseMatch {
  std::vector<MatchedScan> scans;  ///< in the source's order
  std::string origin;              ///< "poses.tum by time"
};

/// By time where both have times (scans without a pose within `max_dt_s` are left out), else by order where
/// the counts agree. @throws InputError where they do not, or no scan meets a pose. `file` names the poses.
PoseMatch MatchPoses(const ScanSource& source, const RecordedPoses& poses, const std::string& file,
                     double max_dt_s);

/// The identity for each scan: only times are wanted.
PoseMatch NoPoses(const ScanSource& source);

/// The poses that the source itself tells; identity for a single scan. @throws InputError without any.
PoseMatch OwnPoses(const ScanSource& source);

}  // namespace atlas::mapping
