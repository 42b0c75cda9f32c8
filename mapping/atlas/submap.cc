#include "mapping/atlas/submap.h"

namespace atlas::mapping {

using core::Box3;
using core::Vec3;

Box3 BoundsOf(const OccupancyOctree& tree) {
  Box3 box;
  const double side_m = kChunkSide * tree.resolution_m();
  for (const OccupancyOctree::Chunk* chunk : tree.Chunks()) {
    const Vec3 low = side_m * Vec3(chunk->key.x, chunk->key.y, chunk->key.z);
    box.Extend(low);
    box.Extend(low.array() + side_m);
  }
  return box;
}

Box3 BoxAround(const Box3& box, const core::Pose& T) {
  Box3 around;
  if (box.Empty()) return around;
  for (int corner = 0; corner < 8; ++corner) {
    const auto side = [&](int axis) { return (corner >> axis & 1) != 0 ? box.max[axis] : box.min[axis]; };
    around.Extend(T * Vec3(side(0), side(1), side(2)));
  }
  return around;
}

}  // namespace atlas::mapping
