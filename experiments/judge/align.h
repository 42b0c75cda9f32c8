// Rigid alignment of a measured cloud to ground truth: point-to-plane ICP for small motions.
#pragma once

#include <span>

#include "core/geometry.h"
#include "experiments/judge/point_grid.h"

namespace atlas::experiments {

struct AlignOptions {
  int correspondences = 20000;
  int max_iterations = 30;
  double first_gate_m = 0.20;    ///< pairs farther apart are ignored in the first round ...
  double last_gate_m = 0.06;     ///< ... and in the last; it shrinks by half a round
  double robust_scale_m = 0.03;  ///< of the Cauchy weight
  /// Pull towards the start, as a share of the pairs' weight: holds the directions that a plane leaves free.
  double prior_share = 1e-3;
};

struct AlignResult {
  core::Pose T_truth_cloud;
  int pairs = 0;       ///< in the last round
  double rms_m = 0.0;  ///< point-to-plane, last round, robustly weighted
};

/// The small rigid motion that lays `cloud` on the truth, starting from `T_start`. Deterministic: pairs are
/// taken at a fixed stride. With fewer than 100 pairs the start is returned.
AlignResult AlignToTruth(std::span<const core::Vec3f> cloud, const PointGrid& truth,
                         std::span<const core::Vec3f> truth_points,
                         std::span<const core::Vec3f> truth_normals, const core::Pose& T_start,
                         const AlignOptions& options);

}  // namespace atlas::experiments
