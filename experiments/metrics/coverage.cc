#include "experiments/metrics/coverage.h"

#include <cassert>
#include <cmath>

#include "experiments/metrics/align.h"
#include "experiments/metrics/statistics.h"

namespace atlas::experiments {
namespace {

using core::Box3;
using core::Pose;
using core::Vec3;
using core::Vec3f;

constexpr float kErrorLimitM = 0.5f;
constexpr size_t kErrorSamples = 50000;
constexpr double kSurroundingsCellM = 0.1;

Box3 BoundsOf(const std::vector<Vec3f>& points) {
  Box3 box;
  for (const Vec3f& p : points) box.Extend(p.cast<double>());
  return box;
}

/// The greatest motion of a corner of `box` between two poses.
double CornerMotion(const Box3& box, const Pose& a, const Pose& b) {
  double greatest = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p((corner & 1 ? box.max : box.min).x(), (corner & 2 ? box.max : box.min).y(),
                 (corner & 4 ? box.max : box.min).z());
    greatest = std::max(greatest, (a * p - b * p).norm());
  }
  return greatest;
}

/// Distance to the truth's surface: along the normal where the nearest sample stands opposite, else to the
/// sample.
double SurfaceDistance(const Vec3f& p, const Vec3f& q, const Vec3f& n, float distance) {
  constexpr float kSampleReach = 0.015f;  // samples lie 1 cm apart
  const float along = std::abs(n.dot(p - q));
  const float across_sq = distance * distance - along * along;
  return across_sq <= kSampleReach * kSampleReach ? along : distance;
}

}  // namespace

CoverageScorer::CoverageScorer(const std::vector<Vec3f>& truth_points, double radius_m)
    : CoverageScorer(std::make_shared<PointGrid>(truth_points, 2.0 * radius_m), radius_m) {}

CoverageScorer::CoverageScorer(std::shared_ptr<const PointGrid> truth, double radius_m)
    : radius_m_(radius_m), grid_(std::move(truth)) {
  assert(radius_m > 0.0);
  Reset();
}

CoverageScorer::CoverageScorer(std::shared_ptr<const PointGrid> truth, const scenes::GroundTruth& sides,
                               double radius_m)
    : CoverageScorer(std::move(truth), radius_m) {
  assert(sides.normals.size() == entries_.size());
  assert(sides.two_sided.empty() || sides.two_sided.size() == entries_.size());
  sides_ = &sides;
}

void CoverageScorer::Reset() {
  entries_ = grid_->entries();
  unmarked_.resize(grid_->cell_count());
  for (size_t cell = 0; cell < unmarked_.size(); ++cell) {
    const int32_t id = static_cast<int32_t>(cell);
    unmarked_[cell] = grid_->CellEnd(id) - grid_->CellBegin(id);
  }
  covered_.assign(entries_.size(), 0);
  covered_count_ = 0;
}

void CoverageScorer::AddPoints(std::span<const Vec3f> points, const Pose& T) {
  assert(sides_ == nullptr);
  if (entries_.empty()) return;
  const auto any = [](const PointGrid::Entry&) { return true; };
  if (T.matrix() == Pose::Identity().matrix()) {
    for (const Vec3f& p : points) MarkAround(p, any);
    return;
  }
  const Eigen::Matrix3f R = T.linear().cast<float>();
  const Vec3f t = T.translation().cast<float>();
  for (const Vec3f& p : points) MarkAround(R * p + t, any);
}

void CoverageScorer::AddReturns(std::span<const Vec3f> points, std::span<const Vec3f> origins,
                                const Pose& T) {
  assert(points.size() == origins.size());
  if (sides_ == nullptr) return AddPoints(points, T);
  if (entries_.empty()) return;
  const Eigen::Matrix3f R = T.linear().cast<float>();
  const Vec3f t = T.translation().cast<float>();
  for (size_t i = 0; i < points.size(); ++i) {
    const Vec3f origin = R * origins[i] + t;
    MarkAround(R * points[i] + t, [&](const PointGrid::Entry& q) {
      if (!sides_->two_sided.empty() && sides_->two_sided[q.index] != 0) return true;
      return sides_->normals[q.index].dot(origin - q.p) > 0.0f;
    });
  }
}

template <typename Counts>
void CoverageScorer::MarkAround(const Vec3f& p, const Counts& counts) {
  PointGrid::CellRange range;
  const float radius = static_cast<float>(radius_m_);
  if (!grid_->CellsAround(p, radius, &range)) return;
  const float radius_sq = radius * radius;
  for (int z = range.lo[2]; z <= range.hi[2]; ++z) {
    for (int y = range.lo[1]; y <= range.hi[1]; ++y) {
      for (int x = range.lo[0]; x <= range.hi[0]; ++x) {
        const int32_t cell = grid_->CellAt(x, y, z);
        if (cell < 0) continue;
        uint32_t& unmarked = unmarked_[static_cast<size_t>(cell)];
        const uint32_t begin = grid_->CellBegin(cell);
        for (uint32_t i = 0; i < unmarked;) {
          PointGrid::Entry& entry = entries_[begin + i];
          if ((entry.p - p).squaredNorm() > radius_sq || !counts(entry)) {
            ++i;
            continue;
          }
          covered_[entry.index] = 1;
          ++covered_count_;
          std::swap(entry, entries_[begin + --unmarked]);
        }
      }
    }
  }
}

double CoverageScorer::coverage_raw() const {
  return covered_.empty() ? 0.0 : static_cast<double>(covered_count_) / static_cast<double>(covered_.size());
}

double ShareOf(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
  assert(a.size() == b.size());
  size_t both = 0, all = 0;
  for (size_t i = 0; i < b.size(); ++i) {
    all += b[i] != 0;
    both += a[i] != 0 && b[i] != 0;
  }
  return all > 0 ? static_cast<double>(both) / static_cast<double>(all) : 0.0;
}

std::vector<PartCoverage> CoverageByPart(const scenes::GroundTruth& truth,
                                         const std::vector<uint8_t>& covered) {
  assert(covered.size() == truth.points.size());
  std::vector<PartCoverage> parts(truth.part_names.size());
  for (size_t i = 0; i < parts.size(); ++i) parts[i].name = truth.part_names[i];
  for (size_t i = 0; i < covered.size(); ++i) {
    PartCoverage& part = parts[truth.part[i]];
    ++part.points;
    part.covered += covered[i] != 0;
  }
  return parts;
}

CoverageMeter::CoverageMeter(const scenes::GroundTruth& truth, const Options& options)
    : truth_(truth),
      options_(options),
      truth_box_(BoundsOf(truth.points)),
      grid_(std::make_shared<PointGrid>(truth.points, 2.0 * options.radius_m)),
      raw_(grid_, options.radius_m),
      aligned_(grid_, options.radius_m),
      outer_(grid_, truth, options.radius_m) {
  assert(truth.normals.size() == truth.points.size());
}

void CoverageMeter::Take(const mapping::ReturnCloud& cloud) {
  raw_.AddPoints(cloud.points, Pose::Identity());
  const size_t counted = kept_.points.size();
  const Box3 box = truth_box_.Inflated(options_.keep_margin_m);
  for (size_t i = 0; i < cloud.points.size(); ++i) {
    if (box.Contains(cloud.points[i].cast<double>())) kept_.Add(cloud.points[i], cloud.origins[i]);
  }
  Count(counted);
}

void CoverageMeter::Count(size_t first) {
  const auto points = std::span<const Vec3f>(kept_.points).subspan(first),
             origins = std::span<const Vec3f>(kept_.origins).subspan(first);
  aligned_.AddPoints(points, T_counted_);
  outer_.AddReturns(points, origins, T_counted_);
}

void CoverageMeter::Align() {
  T_truth_cloud_ =
      AlignToTruth(kept_.points, *grid_, truth_.points, truth_.normals, T_truth_cloud_, AlignOptions{})
          .T_truth_cloud;
  if (CornerMotion(truth_box_, T_truth_cloud_, T_counted_) <= options_.recount_above_m) return;
  aligned_.Reset();
  outer_.Reset();
  T_counted_ = T_truth_cloud_;
  Count(0);
}

void CoverageMeter::SetSurroundings(const std::vector<Vec3f>& points) {
  surroundings_ = PointGrid(points, kSurroundingsCellM);
}

CloudError CoverageMeter::MeasureCloudError(const Box3& object_box) const {
  const Eigen::Matrix3f R = T_truth_cloud_.linear().cast<float>();
  const Vec3f t = T_truth_cloud_.translation().cast<float>();
  std::vector<double> errors;
  const size_t stride = std::max<size_t>(1, kept_.points.size() / kErrorSamples);
  for (size_t i = 0; i < kept_.points.size(); i += stride) {
    if (!object_box.Contains(kept_.points[i].cast<double>())) continue;
    const Vec3f p = R * kept_.points[i] + t;
    float to_object = kErrorLimitM, to_other = kErrorLimitM;
    const int64_t nearest = grid_->Nearest(p, kErrorLimitM, &to_object);
    if (surroundings_.Nearest(p, to_object, &to_other) >= 0 && to_other < to_object) continue;
    const size_t q = static_cast<size_t>(nearest);
    errors.push_back(nearest < 0 ? kErrorLimitM
                                 : SurfaceDistance(p, truth_.points[q], truth_.normals[q], to_object));
  }
  return {.points = errors.size(), .mean_m = Describe(errors).mean, .p95_m = Percentile(errors, 0.95)};
}

}  // namespace atlas::experiments
