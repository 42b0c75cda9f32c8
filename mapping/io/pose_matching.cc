#include "mapping/io/pose_matching.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/errors.h"

namespace atlas::mapping {
namespace {

using core::InputError;

/// Between scans of which nothing tells the time.
constexpr double kPeriod_s = 0.1;

bool AllTimed(const std::vector<ScanEntry>& entries) {
  return std::all_of(entries.begin(), entries.end(),
                     [](const ScanEntry& e) { return e.stamp_s.has_value(); });
}

double StampByOrder(const ScanEntry& entry, size_t i) {
  return entry.stamp_s.value_or(kPeriod_s * static_cast<double>(i));
}

PoseMatch MatchByTime(const ScanSource& source, const RecordedPoses& poses, const std::string& file,
                      double max_dt_s) {
  const auto& entries = source.entries();
  PoseMatch match;
  match.origin = fmt::format("{} by time", file);
  for (size_t i = 0; i < entries.size(); ++i) {
    const auto pose = PoseNear(poses, *entries[i].stamp_s, max_dt_s);
    if (pose) match.scans.push_back({i, *entries[i].stamp_s, *pose});
  }
  if (match.scans.empty()) {
    throw InputError(
        fmt::format("{}: no pose within {} s of a scan of {} (poses from {:.3f} to {:.3f}, scans from {:.3f} "
                    "to {:.3f})",
                    file, max_dt_s, source.description(), poses.time_s.front(), poses.time_s.back(),
                    *entries.front().stamp_s, *entries.back().stamp_s));
  }
  return match;
}

PoseMatch MatchByOrder(const ScanSource& source, const RecordedPoses& poses, const std::string& file) {
  const auto& entries = source.entries();
  if (poses.size() != entries.size()) {
    throw InputError(
        fmt::format("{}: {} poses for {} scans of {}: without times in both their counts must agree", file,
                    poses.size(), entries.size(), source.description()));
  }
  PoseMatch match;
  match.origin = fmt::format("{} by order", file);
  for (size_t i = 0; i < entries.size(); ++i) {
    const double stamp = poses.timed() ? poses.time_s[i] : StampByOrder(entries[i], i);
    match.scans.push_back({i, stamp, poses.T_map_lidar[i]});
  }
  return match;
}

}  // namespace

PoseMatch MatchPoses(const ScanSource& source, const RecordedPoses& poses, const std::string& file,
                     double max_dt_s) {
  const bool by_time = poses.timed() && AllTimed(source.entries());
  PoseMatch match = by_time ? MatchByTime(source, poses, file, max_dt_s) : MatchByOrder(source, poses, file);
  if (!poses.note.empty()) match.origin += fmt::format(" ({})", poses.note);
  return match;
}

PoseMatch NoPoses(const ScanSource& source) {
  PoseMatch match;
  match.origin = "none";
  for (size_t i = 0; i < source.entries().size(); ++i)
    match.scans.push_back({i, StampByOrder(source.entries()[i], i), core::Pose::Identity()});
  return match;
}

PoseMatch OwnPoses(const ScanSource& source) {
  const auto& entries = source.entries();
  PoseMatch match;
  match.origin = source.pose_origin();
  const bool has_poses = std::all_of(entries.begin(), entries.end(),
                                     [](const ScanEntry& e) { return e.T_map_lidar.has_value(); });
  if (!has_poses && entries.size() != 1)
    throw InputError(fmt::format(
        "{}: nothing tells the poses of these {} scans: give --poses FILE (TUM, KITTI or 4x4 "
        "matrices), or put it beside them as poses.tum or poses.txt; atlas slam maps a log without",
        source.description(), entries.size()));
  if (!has_poses) match.origin = "identity";
  for (size_t i = 0; i < entries.size(); ++i)
    match.scans.push_back(
        {i, StampByOrder(entries[i], i), entries[i].T_map_lidar.value_or(core::Pose::Identity())});
  return match;
}

}  // namespace atlas::mapping
