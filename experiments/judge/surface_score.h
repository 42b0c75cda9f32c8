// How well a reconstructed surface fits a truth cloud: accuracy, completeness and coverage, as is and after
// rigid alignment.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/geometry.h"
#include "core/mesh.h"
#include "experiments/judge/align.h"
#include "experiments/judge/point_grid.h"

namespace atlas::experiments {

struct SurfaceScoreOptions {
  std::vector<double> radii_m = {0.043, 0.086};  ///< of coverage (thesis Eq. 3.9)
  double limit_m = 0.5;                          ///< longer distances count as this
  int threads = 1;
};

/// Distances between samples of a surface and truth points, both ways, in metres.
struct SurfaceScore {
  double accuracy_mean_m = 0.0, accuracy_median_m = 0.0, accuracy_p95_m = 0.0;  ///< surface to truth
  double outlier_share = 0.0;        ///< of the surface samples, with no truth within the limit
  double completeness_mean_m = 0.0;  ///< truth to surface
  std::vector<double> coverage;      ///< share of the truth with a sample within each radius
};

class SurfaceScorer {
 public:
  /// @throws InputError when the truth has no points. @pre radii and limit > 0
  SurfaceScorer(std::vector<core::Vec3f> truth, const SurfaceScoreOptions& options);

  /// Score of the samples moved by `T_truth_surface`.
  SurfaceScore Score(std::span<const core::Vec3f> surface, const core::Pose& T_truth_surface) const;
  /// The small rigid motion that lays the samples on the truth (experiments/judge/align.h).
  AlignResult Align(std::span<const core::Vec3f> surface) const;
  size_t truth_count() const { return truth_.size(); }

 private:
  SurfaceScoreOptions options_;
  std::vector<core::Vec3f> truth_;
  PointGrid grid_;
};

/// Points spread evenly over a mesh, one every `spacing_m` squared of area, the same each time.
std::vector<core::Vec3f> SampleMesh(const core::TriMesh& mesh, double spacing_m);

/// Unit normals (of either sign) from the principal axes of each point's nearest neighbours; zero where they
/// do not span a plane.
std::vector<core::Vec3f> EstimateNormals(std::span<const core::Vec3f> points, int neighbours);

}  // namespace atlas::experiments
