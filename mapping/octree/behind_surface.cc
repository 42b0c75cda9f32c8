#include "mapping/octree/behind_surface.h"

namespace atlas::mapping {

BehindSurface::BehindSurface(double resolution_m, double depth_m)
    : resolution_m_(resolution_m), depth_m_(depth_m) {}

void BehindSurface::Mark(const UndistortedSpin& spin, double max_range_m) {
  hit_.clear();
  for (const MapRay& ray : spin.hits) {
    if (ray.range_m > static_cast<float>(max_range_m)) continue;
    const core::Vec3 direction = ray.direction_map.cast<double>();
    const core::Vec3 end = ray.origin_map.cast<double>() + static_cast<double>(ray.range_m) * direction;
    if (!hit_.insert(PackedKey(VoxelKeyAt(end, 1.0 / resolution_m_))).second) continue;
    ForEachBehind(end, direction, resolution_m_, depth_m_, [&](const core::Vec3& p_map, int value) {
      const NodeKey voxel = VoxelKeyAt(p_map, 1.0 / resolution_m_);
      uint8_t& mark = blocks_.try_emplace(PackedKey(voxel.Up(kBlockLevel)), Block{})
                          .first->second[static_cast<size_t>(VoxelIndex(voxel.x, voxel.y, voxel.z))];
      mark = std::max(mark, static_cast<uint8_t>(value));
      return true;
    });
  }
}

void BehindSurface::Merge(const BehindSurface& other, const core::Pose& T_here_other) {
  for (const auto& [key, marks] : other.blocks_) {
    const NodeKey block = UnpackedKey(key);
    for (int i = 0; i < kBlockVoxels; ++i) {
      if (marks[static_cast<size_t>(i)] == 0) continue;
      const core::Vec3 middle(8 * block.x + (i & 7) + 0.5, 8 * block.y + (i >> 3 & 7) + 0.5,
                              8 * block.z + (i >> 6) + 0.5);
      const NodeKey voxel = VoxelKeyAt(T_here_other * (other.resolution_m_ * middle), 1.0 / resolution_m_);
      uint8_t& mark = blocks_.try_emplace(PackedKey(voxel.Up(kBlockLevel)), Block{})
                          .first->second[static_cast<size_t>(VoxelIndex(voxel.x, voxel.y, voxel.z))];
      mark = std::max(mark, marks[static_cast<size_t>(i)]);
    }
  }
}

void BehindSurface::AppendTo(std::string* out) const {
  const auto append = [out](const auto& value) {
    out->append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  std::vector<uint64_t> keys;
  for (const auto& [key, marks] : blocks_) keys.push_back(key);
  std::sort(keys.begin(), keys.end());
  append(resolution_m_);
  append(depth_m_);
  append(uint64_t{keys.size()});
  for (const uint64_t key : keys) {
    append(key);
    append(blocks_.at(key));
  }
}

BehindSurface BehindSurface::Read(core::ByteReader* reader) {
  const auto resolution_m = reader->Next<double>(), depth_m = reader->Next<double>();
  BehindSurface marks(resolution_m, depth_m);
  const auto count = reader->Next<uint64_t>();
  reader->Require(count, sizeof(uint64_t) + sizeof(Block), "marks");
  marks.blocks_.reserve(count);
  for (uint64_t i = 0; i < count; ++i) {
    const auto key = reader->Next<uint64_t>();
    const std::string_view bytes = reader->Take(sizeof(Block));
    std::copy(bytes.begin(), bytes.end(), marks.blocks_[key].begin());
  }
  return marks;
}

const BehindSurface::Block* BehindSurface::Find(const NodeKey& voxel) const {
  const auto found = blocks_.find(PackedKey(voxel.Up(kBlockLevel)));
  return found == blocks_.end() ? nullptr : &found->second;
}

}  // namespace atlas::mapping
