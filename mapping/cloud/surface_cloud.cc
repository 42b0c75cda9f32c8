#include "mapping/cloud/surface_cloud.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <nanoflann.hpp>

#include "core/parallel_for.h"
#include "core/rng.h"

namespace atlas::mapping {
namespace {

using core::Vec3;
using core::Vec3f;

struct CloudPoints {
  std::vector<Vec3f> points;
  size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(size_t i, size_t axis) const { return points[i][static_cast<Eigen::Index>(axis)]; }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};
using CloudTree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, CloudPoints>,
                                                      CloudPoints, 3, uint32_t>;
#if NANOFLANN_VERSION >= 0x150
using TreeSearch = nanoflann::SearchParameters;
#else
using TreeSearch = nanoflann::SearchParams;
#endif

/// What the tree's search fills: the one nearest point, of equally near ones that of the lowest index.
class NearestOne {
 public:
  explicit NearestOne(float max_distance_sq) : distance_sq_(max_distance_sq) {}
  size_t size() const { return index_ >= 0 ? 1 : 0; }
  bool empty() const { return index_ < 0; }
  bool full() const { return true; }
  bool addPoint(float distance_sq, uint32_t index) {
    if (distance_sq < distance_sq_ || (distance_sq == distance_sq_ && index_ > int64_t{index})) {
      distance_sq_ = distance_sq;
      index_ = index;
    }
    return true;
  }
  float worstDist() const { return distance_sq_; }
  void sort() const {}
  int64_t index() const { return index_; }

 private:
  float distance_sq_;
  int64_t index_ = -1;
};

uint64_t CellKey(const Vec3f& p, double inverse_voxel) {
  uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto cell = static_cast<int64_t>(std::floor(static_cast<double>(p[axis]) * inverse_voxel));
    key = (key << 21) | (static_cast<uint64_t>(cell + (1 << 20)) & 0x1fffff);
  }
  return key;
}

/// Neighbours count up to so far. Down a corridor beams graze the walls: returns lie metres apart along them
/// and decimetres across, and a plane through the nearest of them would stand across the corridor.
constexpr float kReachVoxels = 3.0f;
constexpr size_t kLeastNeighbours = 5;

/// Of the plane through the neighbours, facing the viewpoint. A line fits them where the second axis of their
/// scatter is below a tenth of the first: rows of a LiDAR far from their neighbours.
Vec3f NormalOf(const std::vector<Vec3f>& points, const uint32_t* index, size_t count,
               const Vec3f& to_viewpoint) {
  constexpr double kLineShare = 0.1 * 0.1;
  if (count < kLeastNeighbours) return Vec3f::Zero();
  Vec3 mean = Vec3::Zero();
  for (size_t k = 0; k < count; ++k) mean += points[index[k]].cast<double>();
  mean /= static_cast<double>(count);
  core::Mat3 scatter = core::Mat3::Zero();
  for (size_t k = 0; k < count; ++k) {
    const Vec3 d = points[index[k]].cast<double>() - mean;
    scatter += d * d.transpose();
  }
  Eigen::SelfAdjointEigenSolver<core::Mat3> axes;
  axes.computeDirect(scatter);
  if (!(axes.eigenvalues()[1] > kLineShare * axes.eigenvalues()[2])) return Vec3f::Zero();
  const Vec3f normal = axes.eigenvectors().col(0).normalized().cast<float>();
  return normal.dot(to_viewpoint) < 0.0f ? Vec3f(-normal) : normal;
}

}  // namespace

double ChooseVoxel(std::span<const Vec3f> points, const Vec3f& viewpoint) {
  constexpr double kCellsToMedian = 40.0, kLeast_m = 0.1, kMost_m = 0.5;
  std::vector<float> distance;
  distance.reserve(points.size());
  for (const Vec3f& p : points) {
    if (p.allFinite()) distance.push_back((p - viewpoint).norm());
  }
  if (distance.empty()) return kLeast_m;
  const auto middle = distance.begin() + static_cast<std::ptrdiff_t>(distance.size() / 2);
  std::nth_element(distance.begin(), middle, distance.end());
  return std::clamp(static_cast<double>(*middle) / kCellsToMedian, kLeast_m, kMost_m);
}

std::vector<Vec3f> ThinToVoxels(std::span<const Vec3f> points, double voxel_m) {
  assert(voxel_m > 0.0);
  constexpr uint32_t kFree = ~uint32_t{0};
  struct Cell {
    uint64_t key;
    uint32_t count;
    Vec3 sum;
  };
  size_t capacity = 1024;
  while (capacity < 2 * points.size()) capacity *= 2;
  std::vector<uint32_t> slots(capacity, kFree);
  std::vector<Cell> cells;
  const double inverse = 1.0 / voxel_m;
  for (const Vec3f& p : points) {
    if (!p.allFinite()) continue;
    const uint64_t key = CellKey(p, inverse);
    size_t slot = core::HashCounter(0, key) & (capacity - 1);
    while (slots[slot] != kFree && cells[slots[slot]].key != key) slot = (slot + 1) & (capacity - 1);
    if (slots[slot] == kFree) {
      slots[slot] = static_cast<uint32_t>(cells.size());
      cells.push_back({key, 0, Vec3::Zero()});
    }
    Cell& cell = cells[slots[slot]];
    ++cell.count;
    cell.sum += p.cast<double>();
  }
  std::vector<Vec3f> means;
  means.reserve(cells.size());
  for (const Cell& cell : cells) means.push_back((cell.sum / cell.count).cast<float>());
  return means;
}

struct SurfaceCloud::Impl {
  Impl(std::vector<Vec3f> thinned, double side_m)
      : cloud{std::move(thinned)},
        voxel_m(side_m),
        tree(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(12)) {}
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  CloudPoints cloud;
  std::vector<Vec3f> normals;
  double voxel_m;
  CloudTree tree;
};

SurfaceCloud::SurfaceCloud(std::span<const Vec3f> points, const SurfaceCloudParams& params) {
  assert(params.neighbours >= 5);
  const double voxel_m = params.voxel_m > 0.0 ? params.voxel_m : ChooseVoxel(points, params.viewpoint);
  impl_ = std::make_unique<Impl>(ThinToVoxels(points, voxel_m), voxel_m);
  const std::vector<Vec3f>& thinned = impl_->cloud.points;
  impl_->normals.assign(thinned.size(), Vec3f::Zero());
  if (thinned.empty()) return;
  const auto neighbours = static_cast<size_t>(params.neighbours);
  const float reach_m = kReachVoxels * static_cast<float>(voxel_m), reach_sq = reach_m * reach_m;
  core::ParallelFor(params.threads, thinned.size(), [&](size_t begin, size_t end, size_t) {
    std::vector<uint32_t> index(neighbours);
    std::vector<float> distance_sq(neighbours);
    for (size_t i = begin; i < end; ++i) {
      const size_t nearest =
          impl_->tree.knnSearch(thinned[i].data(), neighbours, index.data(), distance_sq.data());
      const auto found = static_cast<size_t>(
          std::upper_bound(distance_sq.begin(), distance_sq.begin() + static_cast<std::ptrdiff_t>(nearest),
                           reach_sq) -
          distance_sq.begin());
      impl_->normals[i] = NormalOf(thinned, index.data(), found, params.viewpoint - thinned[i]);
    }
  });
}

SurfaceCloud::SurfaceCloud(SurfaceCloud&&) noexcept = default;
SurfaceCloud& SurfaceCloud::operator=(SurfaceCloud&&) noexcept = default;
SurfaceCloud::~SurfaceCloud() = default;

const std::vector<Vec3f>& SurfaceCloud::points() const {
  return impl_->cloud.points;
}
const std::vector<Vec3f>& SurfaceCloud::normals() const {
  return impl_->normals;
}
double SurfaceCloud::voxel_m() const {
  return impl_->voxel_m;
}

int64_t SurfaceCloud::Nearest(const Vec3f& p, float max_distance_m) const {
  if (impl_->cloud.points.empty()) return -1;
  NearestOne nearest(max_distance_m * max_distance_m);
  impl_->tree.findNeighbors(nearest, p.data(), TreeSearch());
  return nearest.index();
}

}  // namespace atlas::mapping
