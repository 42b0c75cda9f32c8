// What per-ray poses are worth: maps of a moving LiDAR with motion-aware integration off and on
// (thesis 4.5.3, Fig. 3.15, Fig. 4.8).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/geometry.h"

namespace atlas::experiments {

/// A map's surface against the scene's.
struct MotionError {
  bool motion_aware = false;
  double mean_m = 0.0, p95_m = 0.0;  ///< of mesh vertices to the nearest true surface
  double beyond_voxel = 0.0;         ///< share of vertices farther than a voxel: doubled surfaces
  double completeness = 0.0;         ///< share of true surface in view with a vertex within a voxel
  std::vector<core::Vec3f> slice;    ///< vertices of the picture's layer
};

struct MotionCase {
  std::string name, scene, lidar, motion;
  double resolution_m = 0.05;
  MotionError off = {}, on = {};
  std::vector<core::Vec3f> truth_slice = {};
};

/// A rolling sweep (40 degrees to either side in 6 s) beside the helicopter with a VLP-16, and a turn at
/// 180 degrees a second in a room with an OS1-64. Noise on, repeats exactly.
std::vector<MotionCase> RunMotionBench(int threads);

std::string MotionTable(const std::vector<MotionCase>& cases);
/// motion.md, motion.csv, and a picture a case: the layer with per-ray poses off and on, the truth beneath.
void WriteMotionBench(const std::filesystem::path& folder, const std::vector<MotionCase>& cases);

}  // namespace atlas::experiments
