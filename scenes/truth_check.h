// Is a ground truth what it says: on the meshes, complete, of its spacing? Judged from the triangles, without
// the code that laid the points.
#pragma once

#include "scenes/catalog.h"

namespace atlas::scenes {

struct TruthReport {
  double spacing_m = 0.0;
  // Distances of the points to the object's triangles.
  static constexpr double kOffMesh_m = 1e-4;
  size_t points = 0;
  size_t off_mesh = 0;                    ///< farther than kOffMesh_m
  double mean_m = 0.0, greatest_m = 0.0;  ///< distances beyond 3 m count as 3 m
  // Exposed surface, drawn at random by area, and how far the nearest truth point is.
  size_t drawn = 0, exposed = 0;
  static constexpr double kMostMissed = 1e-3, kWorstGapSpacings = 1.25;  // at rims; see ground_truth.cc
  size_t missed = 0;         ///< exposed, with no truth within the spacing
  double worst_gap_m = 0.0;  ///< ends at 3 spacings
  core::Vec3 worst_gap_map = core::Vec3::Zero();

  bool good() const {
    return points > 0 && off_mesh == 0 &&
           static_cast<double>(missed) <= kMostMissed * static_cast<double>(exposed) &&
           worst_gap_m <= kWorstGapSpacings * spacing_m;
  }
};

/// @param draws surface points that completeness is tried at. Deterministic.
TruthReport CheckTruth(const SceneSpec& scene, const GroundTruth& truth, double spacing_m, int draws);

/// A part's mesh, piece by piece.
struct PartReport {
  std::string name;
  bool is_object = false;
  size_t triangles = 0, shells = 0;
  size_t open_shells = 0;     ///< not watertight: they bury nothing, and both their sides count
  size_t inward_shells = 0;   ///< watertight, but the faces look inward
  size_t flat_triangles = 0;  ///< without area
};
std::vector<PartReport> CheckParts(const SceneSpec& scene);

}  // namespace atlas::scenes
