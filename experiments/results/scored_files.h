// The files of a run folder that coverage was counted from, so that a reader can count it again
// (docs/recompute_coverage.py does, in twenty lines).
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/geometry.h"
#include "mapping/cloud/scan_cloud.h"
#include "scenes/catalog.h"

namespace atlas::experiments {

/// Binary PLY of the truth as scored, map frame, a vertex a point in the order of `truth`:
/// float x y z (m), float nx ny nz (unit, outward), uchar attainable (0 or 1), uchar two_sided (0 or 1).
/// `attainable`: a flag a point, or empty where it is not known, and then no property. @throws InputError
/// when the path cannot be written.
void WriteScoredTruth(const std::filesystem::path& path, const scenes::GroundTruth& truth,
                      const std::vector<uint8_t>& attainable);

/// Binary PLY of the first `count` returns, map frame as estimated:
/// float x y z (m), float vp_x vp_y vp_z (m, where the sensor was).
void WriteScoredCloud(const std::filesystem::path& path, const mapping::ReturnCloud& cloud, size_t count);

/// Text, four rows of four numbers: T_truth_cloud, which takes points of cloud.ply to ground_truth.ply.
void WriteAlignment(const std::filesystem::path& path, const core::Pose& T_truth_cloud);

}  // namespace atlas::experiments
