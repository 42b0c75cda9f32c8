// Point cloud coverage (thesis Eq. 3.9): the share of ground-truth points with an accumulated-cloud point
// within a radius, 4.3 cm for the object scenes.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/geometry.h"
#include "core/mesh.h"
#include "experiments/metrics/point_grid.h"
#include "scenes/catalog.h"
#include "scenes/scene_spec.h"

namespace atlas::experiments {

/// Radius of Eq. 3.9 for the object scenes: half the diagonal of a 5 cm voxel.
constexpr double kObjectCoverageRadiusM = 0.043;
/// The same for the areas of chapter 4.
constexpr double kAreaCoverageRadiusM = 0.086;

/// Marks ground-truth points as clouds come in; exact, and cheap where all is marked already. Map frame.
class CoverageScorer {
 public:
  /// @pre radius_m > 0
  CoverageScorer(const std::vector<core::Vec3f>& truth_points, double radius_m);
  /// Scores against points already bucketed with cells of twice the radius.
  CoverageScorer(std::shared_ptr<const PointGrid> truth, double radius_m);

  void AddCloud(const core::PointCloud& cloud) { AddPoints(cloud.points, core::Pose::Identity()); }
  /// Adds points moved by `T`.
  void AddPoints(std::span<const core::Vec3f> points, const core::Pose& T);
  /// Forgets all clouds.
  void Reset();

  /// N_O / N_GT of Eq. 3.9, in [0, 1]; 0 without truth.
  double coverage_raw() const;
  size_t covered_count() const { return covered_count_; }
  /// 1 where covered, in the order the truth was given.
  const std::vector<uint8_t>& covered() const { return covered_; }
  double radius_m() const { return radius_m_; }
  const std::shared_ptr<const PointGrid>& grid() const { return grid_; }

 private:
  void MarkAround(const core::Vec3f& p);

  double radius_m_;
  std::shared_ptr<const PointGrid> grid_;
  std::vector<PointGrid::Entry> entries_;  // each cell's unmarked points first
  std::vector<uint32_t> unmarked_;         // how many those are, by cell
  std::vector<uint8_t> covered_;
  size_t covered_count_ = 0;
};

/// |a and b| / |b|; 0 for an empty b. @pre equally long
double ShareOf(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b);

/// Coverage of each of the truth's named parts.
struct PartCoverage {
  std::string name;
  size_t points = 0;
  size_t covered = 0;
  double share() const {
    return points > 0 ? static_cast<double>(covered) / static_cast<double>(points) : 0.0;
  }
};
std::vector<PartCoverage> CoverageByPart(const scenes::GroundTruth& truth,
                                         const std::vector<uint8_t>& covered);

/// Distances of measured points to the surface they lie on.
struct CloudError {
  size_t points = 0;
  double mean_m = 0.0;
  double p95_m = 0.0;
};

/// Raw and aligned coverage of one run's accumulated cloud, scan by scan.
///
/// Aligned: the whole accumulated cloud is moved by the one small rigid transform that best fits it to the
/// truth (experiments/metrics/align.h) and scored again. It is recounted in full whenever the transform has
/// moved any corner of the truth's box by more than `recount_above_m` since the last count, else the new
/// cloud is added.
class CoverageMeter {
 public:
  struct Options {
    double radius_m = kObjectCoverageRadiusM;
    double keep_margin_m = 0.5;  ///< cloud points farther from the truth's box never count
    double recount_above_m = 0.001;
  };

  /// Keeps a reference to `truth`. @pre truth has a normal a point
  CoverageMeter(const scenes::GroundTruth& truth, const Options& options);

  /// Adds a sweep's filtered cloud (map frame) and scores both ways.
  void AddCloud(const core::PointCloud& cloud) {
    Take(cloud);
    Align();
  }
  /// AddCloud in two: any number of clouds, scored under the latest fit; then the fit of all and its score.
  void Take(const core::PointCloud& cloud);
  void Align();

  double coverage_raw() const { return raw_.coverage_raw(); }
  double coverage() const { return aligned_.coverage_raw(); }
  const std::vector<uint8_t>& covered() const { return aligned_.covered(); }
  const std::vector<uint8_t>& covered_raw() const { return raw_.covered(); }
  /// Takes points of the accumulated cloud to the truth.
  const core::Pose& T_truth_cloud() const { return T_truth_cloud_; }
  /// Accumulated points near the truth's box, as measured.
  const std::vector<core::Vec3f>& kept_points() const { return kept_; }

  /// Distance of the accumulated points inside `object_box` to the truth's surface, after alignment. A point
  /// that lies nearer to `background` (the scene's other surfaces, sampled) belongs there and is left out;
  /// distances end at 0.5 m.
  CloudError MeasureCloudError(const core::Box3& object_box,
                               const std::vector<core::Vec3f>& background) const;

 private:
  const scenes::GroundTruth& truth_;
  Options options_;
  core::Box3 truth_box_;
  std::shared_ptr<const PointGrid> grid_;
  CoverageScorer raw_;
  CoverageScorer aligned_;
  core::Pose T_truth_cloud_ = core::Pose::Identity();  // latest fit
  core::Pose T_counted_ = core::Pose::Identity();      // fit that aligned_ was counted under
  std::vector<core::Vec3f> kept_;
};

}  // namespace atlas::experiments
