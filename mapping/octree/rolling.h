// The local rolling map (thesis 4.6): an octree that moves with the robot.
#pragma once

#include "mapping/octree/octree.h"

namespace atlas::mapping {

/// Erases the chunks that lie wholly farther than `radius_m` from `centre`; returns how many. Call as the
/// robot moves, and memory stays bounded by what fits the sphere.
template <typename Field>
size_t CropToRange(Octree<Field>* map, const core::Vec3& centre, double radius_m) {
  const double side = kChunkSide * map->resolution_m();
  std::vector<NodeKey> far;
  for (const auto* chunk : map->Chunks()) {
    const core::Vec3 low = side * core::Vec3(chunk->key.x, chunk->key.y, chunk->key.z);
    const core::Box3 box{low, low + core::Vec3::Constant(side)};
    if (box.DistanceTo(centre) > radius_m) far.push_back(chunk->key);
  }
  for (const NodeKey& key : far) map->Erase(key);
  return far.size();
}

}  // namespace atlas::mapping
