#include <Eigen/Eigenvalues>
#include <nanoflann.hpp>

#include "experiments/judge/surface_score.h"

namespace atlas::experiments {
namespace {

using core::Vec3f;

struct PointsAdaptor {
  std::span<const Vec3f> points;
  size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(size_t i, size_t axis) const { return points[i][static_cast<Eigen::Index>(axis)]; }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};
using KdTree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, PointsAdaptor>,
                                                   PointsAdaptor, 3, uint32_t>;

/// Of the plane through `count` points; zero where they lie on a line.
Vec3f PlaneNormal(std::span<const Vec3f> points, const uint32_t* index, size_t count) {
  Vec3f mean = Vec3f::Zero();
  for (size_t k = 0; k < count; ++k) mean += points[index[k]];
  mean /= static_cast<float>(count);
  Eigen::Matrix3f scatter = Eigen::Matrix3f::Zero();
  for (size_t k = 0; k < count; ++k) {
    const Vec3f d = points[index[k]] - mean;
    scatter += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> axes(scatter);
  if (!(axes.eigenvalues()[1] > 1e-3f * axes.eigenvalues()[2])) return Vec3f::Zero();
  return axes.eigenvectors().col(0);
}

}  // namespace

std::vector<Vec3f> EstimateNormals(std::span<const Vec3f> points, int neighbours) {
  std::vector<Vec3f> normals(points.size(), Vec3f::Zero());
  if (points.size() < 3) return normals;
  const PointsAdaptor adaptor{points};
  const KdTree tree(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(16));
  std::vector<uint32_t> index(static_cast<size_t>(neighbours));
  std::vector<float> distance_sq(index.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const size_t found = tree.knnSearch(points[i].data(), index.size(), index.data(), distance_sq.data());
    normals[i] = PlaneNormal(points, index.data(), found);
  }
  return normals;
}

}  // namespace atlas::experiments
