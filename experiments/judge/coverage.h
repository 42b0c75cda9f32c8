// Point cloud coverage (thesis Eq. 3.9): the share of ground-truth points with an accumulated-cloud point
// within a radius, 4.3 cm for the object scenes.
//
// Eq. 3.9 also counts what no beam ever met: the far face of a plate thinner than the radius, and the thicker
// a noisy cloud, the more of it. So coverage is counted by a second rule besides, `coverage_outer`: only
// returns count that were seen from the outer side of the truth point's surface,
//
//        o  sensor            n . (o - q) > 0     q truth, n its outer normal, o where the sensor was
//         \        n          |p - q| <= radius   p the return
//          \       |
//     ------p------q------    outer face
//     -------------q'-----    inner face: o lies behind its plane, so p does not count for q'
//
// Truth on a sheet that encloses no volume has no outer side; returns from either count.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/geometry.h"
#include "core/keyframe.h"
#include "core/mesh.h"
#include "experiments/judge/point_grid.h"
#include "mapping/cloud/scan_cloud.h"
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
  /// As above, by the outer side: keeps a reference to `sides`, whose points `truth` holds.
  CoverageScorer(std::shared_ptr<const PointGrid> truth, const scenes::GroundTruth& sides, double radius_m);

  void AddCloud(const core::PointCloud& cloud) { AddPoints(cloud.points, core::Pose::Identity()); }
  /// Adds points moved by `T`. @pre does not score by the outer side
  void AddPoints(std::span<const core::Vec3f> points, const core::Pose& T);
  /// Adds returns moved by `T`, each with the sensor's place. @pre equally many of both
  void AddReturns(std::span<const core::Vec3f> points, std::span<const core::Vec3f> origins,
                  const core::Pose& T);
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
  /// Points of one cell that look about one way: most returns pass them by with two dot products.
  struct Group {
    uint32_t begin = 0, end = 0, unmarked = 0;  ///< of entries_; the unmarked ones come first
    core::Vec3f center = core::Vec3f::Zero();
    float reach_m = 0.0f;      ///< greatest distance of a point from the centre
    bool has_outside = false;  ///< a side that does not count, and the cone that holds all outer normals:
    core::Vec3f axis = core::Vec3f::Zero();
    float cos_spread = 1.0f, sin_spread = 0.0f;
    /// Whether it may hold a point whose outer side `origin` is on.
    bool MayFace(const core::Vec3f& origin) const;
  };

  void BuildGroups();
  void AddGroup(uint32_t begin, uint32_t end, bool has_outside);
  /// Marks what a return at p covers; seen from `origin`, or null where sides do not matter.
  void MarkAround(const core::Vec3f& p, const core::Vec3f* origin);
  bool IsTwoSided(const PointGrid::Entry& q) const;

  double radius_m_;
  const scenes::GroundTruth* sides_ = nullptr;  // where the outer side decides
  std::shared_ptr<const PointGrid> grid_;
  std::vector<PointGrid::Entry> entries_;  // by group
  std::vector<Group> groups_;              // by cell
  std::vector<uint32_t> group_begin_;      // of each cell, one more at the end
  std::vector<uint32_t> unmarked_;         // points of each cell
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

/// Coverage of one run's accumulated cloud, scan by scan: raw, aligned, and aligned by the outer side.
///
/// Aligned: the whole accumulated cloud is moved by the one small rigid transform that best fits it to the
/// truth (experiments/judge/align.h) and scored again. It is recounted in full whenever the transform has
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

  /// Adds a sweep's filtered cloud (map frame) and scores it.
  void AddCloud(const mapping::ReturnCloud& cloud) {
    Take(cloud);
    Align();
  }
  /// AddCloud in two: any number of clouds, scored under the latest fit; then the fit of all and its score.
  void Take(const mapping::ReturnCloud& cloud);
  void Align();
  /// Take() of what belongs to a keyframe, and moves with it from now on.
  void Take(const mapping::ReturnCloud& cloud, core::KeyframeId keyframe, const core::PoseSource& poses);
  /// Moves what was taken to where its keyframes are; where that changes anything, all is counted anew.
  void Correct(const core::PoseSource& poses);

  double coverage_raw() const { return raw_.coverage_raw(); }
  double coverage() const { return aligned_.coverage_raw(); }
  double coverage_outer() const { return outer_.coverage_raw(); }
  const std::vector<uint8_t>& covered() const { return aligned_.covered(); }
  const std::vector<uint8_t>& covered_raw() const { return raw_.covered(); }
  const std::vector<uint8_t>& covered_outer() const { return outer_.covered(); }
  /// Takes points of the accumulated cloud to the truth: the latest fit.
  const core::Pose& T_truth_cloud() const { return T_truth_cloud_; }
  /// The fit that coverage was counted under, within recount_above_m of the latest.
  const core::Pose& T_truth_cloud_counted() const { return T_counted_; }
  /// Accumulated returns near the truth's box, as measured.
  const mapping::ReturnCloud& kept() const { return kept_; }

  /// The scene's other surfaces, sampled: what lies nearer to them than to the truth belongs there.
  void SetSurroundings(const std::vector<core::Vec3f>& points);
  /// Distance of the accumulated points inside `object_box` to the truth's surface, after alignment, over an
  /// even choice of 50,000. Points that belong to the surroundings are left out; distances end at 0.5 m.
  CloudError MeasureCloudError(const core::Box3& object_box) const;

 private:
  /// Returns that were taken together, [begin, end) of kept_.
  struct Stretch {
    core::KeyframeId keyframe;
    size_t begin, end;
    core::Pose T_map_keyframe;  ///< as they lie
  };

  /// Counts the kept returns from `first` on, under T_counted_.
  void Count(size_t first);
  void Recount();

  const scenes::GroundTruth& truth_;
  Options options_;
  core::Box3 truth_box_;
  std::shared_ptr<const PointGrid> grid_;
  CoverageScorer raw_;
  CoverageScorer aligned_, outer_;
  PointGrid surroundings_{{}, 0.1};
  core::Pose T_truth_cloud_ = core::Pose::Identity();  // latest fit
  core::Pose T_counted_ = core::Pose::Identity();      // fit that aligned_ and outer_ were counted under
  mapping::ReturnCloud kept_;
  std::vector<Stretch> stretches_;
};

}  // namespace atlas::experiments
