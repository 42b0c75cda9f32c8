#include "experiments/judge/coverage.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "experiments/judge/align.h"
#include "experiments/results/statistics.h"

namespace atlas::experiments {
namespace {

using core::Box3;
using core::Pose;
using core::Vec3;
using core::Vec3f;

constexpr float kErrorLimitM = 0.5f;
constexpr size_t kErrorSamples = 50000;
constexpr double kSurroundingsCellM = 0.1;
constexpr float kRounding = 1e-4f;  ///< bounds of groups are wider by this: no point is left out for rounding

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
  BuildGroups();
}

CoverageScorer::CoverageScorer(std::shared_ptr<const PointGrid> truth, const scenes::GroundTruth& sides,
                               double radius_m)
    : radius_m_(radius_m), sides_(&sides), grid_(std::move(truth)) {
  assert(radius_m > 0.0);
  assert(sides.normals.size() == grid_->entries().size());
  assert(sides.two_sided.empty() || sides.two_sided.size() == grid_->entries().size());
  BuildGroups();
}

bool CoverageScorer::IsTwoSided(const PointGrid::Entry& q) const {
  return !sides_->two_sided.empty() && sides_->two_sided[q.index] != 0;
}

void CoverageScorer::BuildGroups() {
  entries_ = grid_->entries();
  // Where sides matter, a cell's points are told apart by the axis that is next to their normal.
  constexpr int kTwoSided = 6;
  const auto way_of = [this](const PointGrid::Entry& q) {
    if (sides_ == nullptr || IsTwoSided(q)) return kTwoSided;
    int axis = 0;
    const Vec3f& n = sides_->normals[q.index];
    n.cwiseAbs().maxCoeff(&axis);
    return 2 * axis + (n[axis] < 0.0f ? 1 : 0);
  };
  group_begin_.assign(1, 0);
  for (size_t cell = 0; cell < grid_->cell_count(); ++cell) {
    const auto id = static_cast<int32_t>(cell);
    const uint32_t end = grid_->CellEnd(id);
    uint32_t begin = grid_->CellBegin(id);
    std::sort(entries_.begin() + begin, entries_.begin() + end,
              [&](const auto& a, const auto& b) { return way_of(a) < way_of(b); });
    for (uint32_t i = begin; i < end; ++i) {
      const int way = way_of(entries_[i]);
      if (i + 1 < end && way_of(entries_[i + 1]) == way) continue;
      AddGroup(begin, i + 1, way != kTwoSided);
      begin = i + 1;
    }
    group_begin_.push_back(static_cast<uint32_t>(groups_.size()));
  }
  Reset();
}

void CoverageScorer::AddGroup(uint32_t begin, uint32_t end, bool has_outside) {
  Group group{.begin = begin, .end = end, .has_outside = has_outside};
  Eigen::AlignedBox3f box;
  for (uint32_t i = begin; i < end; ++i) {
    box.extend(entries_[i].p);
    if (has_outside) group.axis += sides_->normals[entries_[i].index];
  }
  group.center = box.center();
  group.axis.normalize();
  for (uint32_t i = begin; i < end; ++i) {
    group.reach_m = std::max(group.reach_m, (entries_[i].p - group.center).norm());
    if (!has_outside) continue;
    const Vec3f& n = sides_->normals[entries_[i].index];
    group.cos_spread = std::min(group.cos_spread, group.axis.dot(n));
    group.sin_spread = std::max(group.sin_spread, group.axis.cross(n).norm());  // from the cosine: 3e-4 off
  }
  group.reach_m += kRounding;
  groups_.push_back(group);
}

/// n . (o - q) is greatest for the normal of the cone that is next to o - center, and the point nearest to o.
bool CoverageScorer::Group::MayFace(const Vec3f& origin) const {
  const Vec3f d = origin - center;
  const float along = axis.dot(d), length_sq = d.squaredNorm();
  if (along >= 0.0f) return true;
  const float across = std::sqrt(std::max(0.0f, length_sq - along * along));
  return cos_spread <= 0.0f || along * cos_spread + across * sin_spread + reach_m > 0.0f;
}

void CoverageScorer::Reset() {
  for (Group& group : groups_) group.unmarked = group.end - group.begin;
  unmarked_.resize(grid_->cell_count());
  for (size_t cell = 0; cell < unmarked_.size(); ++cell) {
    const auto id = static_cast<int32_t>(cell);
    unmarked_[cell] = grid_->CellEnd(id) - grid_->CellBegin(id);
  }
  covered_.assign(entries_.size(), 0);
  covered_count_ = 0;
}

void CoverageScorer::AddPoints(std::span<const Vec3f> points, const Pose& T) {
  assert(sides_ == nullptr);
  if (entries_.empty()) return;
  if (T.matrix() == Pose::Identity().matrix()) {
    for (const Vec3f& p : points) MarkAround(p, nullptr);
    return;
  }
  const Eigen::Matrix3f R = T.linear().cast<float>();
  const Vec3f t = T.translation().cast<float>();
  for (const Vec3f& p : points) MarkAround(R * p + t, nullptr);
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
    MarkAround(R * points[i] + t, &origin);
  }
}

void CoverageScorer::MarkAround(const Vec3f& p, const Vec3f* origin) {
  PointGrid::CellRange range;
  const float radius = static_cast<float>(radius_m_);
  if (!grid_->CellsAround(p, radius, &range)) return;
  const float radius_sq = radius * radius;
  const auto counts = [&](const PointGrid::Entry& q) {
    return origin == nullptr || IsTwoSided(q) || sides_->normals[q.index].dot(*origin - q.p) > 0.0f;
  };
  const auto mark_in = [&](Group* group) -> uint32_t {
    const float reach = radius + group->reach_m;
    if (group->unmarked == 0 || (p - group->center).squaredNorm() > reach * reach) return 0;
    if (origin != nullptr && group->has_outside && !group->MayFace(*origin)) return 0;
    const uint32_t before = group->unmarked;
    for (uint32_t i = 0; i < group->unmarked;) {
      PointGrid::Entry& entry = entries_[group->begin + i];
      if ((entry.p - p).squaredNorm() > radius_sq || !counts(entry)) {
        ++i;
        continue;
      }
      covered_[entry.index] = 1;
      std::swap(entry, entries_[group->begin + --group->unmarked]);
    }
    covered_count_ += before - group->unmarked;
    return before - group->unmarked;
  };
  for (int z = range.lo[2]; z <= range.hi[2]; ++z) {
    for (int y = range.lo[1]; y <= range.hi[1]; ++y) {
      for (int x = range.lo[0]; x <= range.hi[0]; ++x) {
        const int32_t cell = grid_->CellAt(x, y, z);
        if (cell < 0 || unmarked_[static_cast<size_t>(cell)] == 0) continue;
        const auto at = static_cast<size_t>(cell);
        for (uint32_t g = group_begin_[at]; g < group_begin_[at + 1]; ++g) {
          unmarked_[at] -= mark_in(&groups_[g]);
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

void CoverageMeter::Take(const mapping::ReturnCloud& cloud, core::KeyframeId keyframe,
                         const core::PoseSource& poses) {
  const size_t begin = kept_.points.size();
  Take(cloud);
  stretches_.push_back({keyframe, begin, kept_.points.size(), poses.T_map_keyframe(keyframe)});
}

void CoverageMeter::Correct(const core::PoseSource& poses) {
  bool moved = false;
  for (Stretch& stretch : stretches_) {
    const Pose T_map_keyframe = poses.T_map_keyframe(stretch.keyframe);
    if (T_map_keyframe.matrix() == stretch.T_map_keyframe.matrix()) continue;
    const Eigen::Isometry3f move = (T_map_keyframe * stretch.T_map_keyframe.inverse()).cast<float>();
    for (size_t i = stretch.begin; i < stretch.end; ++i) {
      kept_.points[i] = move * kept_.points[i];
      kept_.origins[i] = move * kept_.origins[i];
    }
    stretch.T_map_keyframe = T_map_keyframe;
    moved = true;
  }
  if (!moved) return;
  raw_.Reset();
  raw_.AddPoints(kept_.points, Pose::Identity());
  Recount();
}

void CoverageMeter::Recount() {
  aligned_.Reset();
  outer_.Reset();
  Count(0);
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
  T_counted_ = T_truth_cloud_;
  Recount();
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
