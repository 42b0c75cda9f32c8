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

/// Eigenvalues ascend.
Eigen::SelfAdjointEigenSolver<core::Mat3> AxesOf(const std::vector<Vec3>& points) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  core::Mat3 scatter = core::Mat3::Zero();
  for (const Vec3& p : points) scatter += (p - mean) * (p - mean).transpose();
  Eigen::SelfAdjointEigenSolver<core::Mat3> axes;
  axes.computeDirect(scatter);
  return axes;
}

/// Of the plane through the neighbours, facing the viewpoint at the origin. A line fits them where the second
/// axis of their scatter is below a tenth of the first: rows of a LiDAR far from their neighbours. So does a
/// line as seen from the viewpoint: one row across an edge, whose plane would stand across the edge and
/// travel with the LiDAR. A plane that is seen obliquely looks narrower by its cosine.
Vec3f NormalOf(const std::vector<Vec3>& neighbours) {
  constexpr double kLineShare = 0.1 * 0.1, kFlatShare = 0.1;
  if (neighbours.size() < kLeastNeighbours) return Vec3f::Zero();
  const auto axes = AxesOf(neighbours);
  if (!(axes.eigenvalues()[1] > kLineShare * axes.eigenvalues()[2])) return Vec3f::Zero();
  if (axes.eigenvalues()[0] > kFlatShare * axes.eigenvalues()[1]) return Vec3f::Zero();
  const Vec3 normal = axes.eigenvectors().col(0).normalized();
  std::vector<Vec3> directions;
  for (const Vec3& p : neighbours) directions.push_back(p.normalized());
  const Vec3 seen = AxesOf(directions).eigenvalues();
  const double cosine = normal.dot(directions.front());
  if (!(seen[1] > kLineShare * cosine * cosine * seen[2])) return Vec3f::Zero();
  return (cosine > 0.0 ? Vec3(-normal) : normal).cast<float>();
}

/// Whether two thirds of the neighbours lie on surfaces turned alike (26 degrees). Far down a corridor the
/// samples of wall and ceiling form planes across it, which no point around them confirms; they travel with
/// the LiDAR, and a scan matched to them would stand still.
bool Confirmed(const Vec3f& normal, std::span<const uint32_t> neighbours, const std::vector<Vec3f>& normals) {
  constexpr float kAlike = 0.9f;
  size_t alike = 0;
  for (const uint32_t k : neighbours) alike += normals[k].dot(normal) > kAlike;
  return 3 * alike >= 2 * neighbours.size();
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

std::vector<Vec3f> ThinToVoxels(std::span<const Vec3f> points, double voxel_m, std::vector<uint32_t>* first) {
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
  if (first != nullptr) first->clear();
  for (size_t i = 0; i < points.size(); ++i) {
    const Vec3f& p = points[i];
    if (!p.allFinite()) continue;
    const uint64_t key = CellKey(p, inverse);
    size_t slot = core::HashCounter(0, key) & (capacity - 1);
    while (slots[slot] != kFree && cells[slots[slot]].key != key) slot = (slot + 1) & (capacity - 1);
    if (slots[slot] == kFree) {
      slots[slot] = static_cast<uint32_t>(cells.size());
      cells.push_back({key, 0, Vec3::Zero()});
      if (first != nullptr) first->push_back(static_cast<uint32_t>(i));
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
  std::vector<uint32_t> first_in_cell;
  double voxel_m;
  CloudTree tree;
};

SurfaceCloud::SurfaceCloud(std::span<const Vec3f> points, const SurfaceCloudParams& params) {
  assert(params.neighbours >= 5);
  const double voxel_m = params.voxel_m > 0.0 ? params.voxel_m : ChooseVoxel(points, params.viewpoint);
  std::vector<uint32_t> first;
  impl_ = std::make_unique<Impl>(ThinToVoxels(points, voxel_m, &first), voxel_m);
  impl_->first_in_cell = std::move(first);
  const std::vector<Vec3f>& thinned = impl_->cloud.points;
  impl_->normals.assign(thinned.size(), Vec3f::Zero());
  if (thinned.empty()) return;
  const auto neighbours = static_cast<size_t>(params.neighbours);
  const float reach_m = kReachVoxels * static_cast<float>(voxel_m), reach_sq = reach_m * reach_m;
  std::vector<uint32_t> index(thinned.size() * neighbours);
  std::vector<size_t> found(thinned.size());
  std::vector<Vec3f> fitted(thinned.size());
  core::ParallelFor(params.threads, thinned.size(), [&](size_t begin, size_t end, size_t) {
    std::vector<float> distance_sq(neighbours);
    std::vector<Vec3> near;
    for (size_t i = begin; i < end; ++i) {
      uint32_t* own = index.data() + i * neighbours;
      const size_t nearest = impl_->tree.knnSearch(thinned[i].data(), neighbours, own, distance_sq.data());
      near.clear();
      for (size_t k = 0; k < nearest && distance_sq[k] <= reach_sq; ++k)
        near.push_back((thinned[own[k]] - params.viewpoint).cast<double>());
      found[i] = near.size();
      fitted[i] = NormalOf(near);
    }
  });
  core::ParallelFor(params.threads, thinned.size(), [&](size_t begin, size_t end, size_t) {
    for (size_t i = begin; i < end; ++i) {
      const bool keep =
          !fitted[i].isZero() && Confirmed(fitted[i], {index.data() + i * neighbours, found[i]}, fitted);
      if (keep) impl_->normals[i] = fitted[i];
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
const std::vector<uint32_t>& SurfaceCloud::first_in_cell() const {
  return impl_->first_in_cell;
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
