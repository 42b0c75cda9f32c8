#include "mapping/backends/octomap_peer.h"

#include <octomap/OcTree.h>

namespace atlas::mapping {

struct OctomapPeer::Impl {
  explicit Impl(double resolution_m) : tree(resolution_m) {}
  octomap::OcTree tree;
  octomap::Pointcloud cloud;
};

OctomapPeer::OctomapPeer(double resolution_m) : impl_(std::make_unique<Impl>(resolution_m)) {}
OctomapPeer::~OctomapPeer() = default;

void OctomapPeer::Insert(std::span<const core::Vec3f> points_map, const core::Vec3& origin_map,
                         double max_range_m) {
  impl_->cloud.clear();
  impl_->cloud.reserve(points_map.size());
  for (const core::Vec3f& p : points_map) impl_->cloud.push_back(p.x(), p.y(), p.z());
  const octomap::point3d origin(static_cast<float>(origin_map.x()), static_cast<float>(origin_map.y()),
                                static_cast<float>(origin_map.z()));
  impl_->tree.insertPointCloud(impl_->cloud, origin, max_range_m, /*lazy_eval=*/false, /*discretize=*/true);
}

CellState OctomapPeer::StateAt(const core::Vec3& p_map) const {
  const octomap::OcTreeNode* node = impl_->tree.search(p_map.x(), p_map.y(), p_map.z());
  if (node == nullptr) return CellState::kUnknown;
  return node->getLogOdds() > 0.0f ? CellState::kOccupied : CellState::kFree;
}

size_t OctomapPeer::Bytes() const {
  return impl_->tree.memoryUsage();
}
size_t OctomapPeer::Nodes() const {
  return impl_->tree.size();
}

}  // namespace atlas::mapping
