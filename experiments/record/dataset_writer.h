// A recorded data set on disk, as `atlas map` reads it:
//
//   scans/<stamp>.pcd   organised clouds, x y z t kind (mapping/io/cloud_writer.h)
//   poses.tum           T_map_lidar at each scan's stamp
//   trajectory.tum      T_map_lidar every 5 ms
//   truth.ply           points on the surfaces that the scans could have met, with normals, without noise
//   dataset.yaml        what was recorded, and how
#pragma once

#include <filesystem>
#include <functional>

#include "experiments/record/recorder.h"

namespace atlas::experiments {

struct DatasetCounts {
  size_t scans = 0, hits = 0, voids = 0, dropouts = 0;
  size_t truth_points = 0;
  bool interrupted = false;  ///< stopped before the last scan; what is written is whole
};

/// Writes the remaining scans of `recorder` below `folder`. `progress(scans done, scans in all)` follows each
/// scan and returns whether to go on. `truth_spacing_m` of zero leaves truth.ply out.
/// @throws InputError where the folder holds scans already or cannot be written.
DatasetCounts WriteDataset(DatasetRecorder* recorder, const std::filesystem::path& folder,
                           double truth_spacing_m, const std::function<bool(size_t, size_t)>& progress);

/// The surfaces of the object that the recorded revolutions could have met, sampled without noise: binary PLY
/// with x y z nx ny nz (float). @returns the number of points
size_t WriteTruth(const DatasetRecorder& recorder, const std::filesystem::path& path, double spacing_m);

}  // namespace atlas::experiments
