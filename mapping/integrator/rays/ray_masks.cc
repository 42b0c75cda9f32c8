#include "mapping/integrator/rays/ray_masks.h"

#include <algorithm>
#include <cstdlib>

#include "core/rng.h"
#include "mapping/integrator/write/tsdf_apply.h"

namespace atlas::mapping {
namespace {

size_t HashOf(const NodeKey& key) {
  const uint64_t packed = static_cast<uint64_t>(static_cast<uint32_t>(key.x)) << 42 ^
                          static_cast<uint64_t>(static_cast<uint32_t>(key.y)) << 21 ^
                          static_cast<uint64_t>(static_cast<uint32_t>(key.z));
  const uint64_t mixed = packed * 0x9e3779b97f4a7c15u;
  return static_cast<size_t>(mixed ^ mixed >> 32);
}

}  // namespace

void RayMasks::Clear() {
  blocks_.resize(1);
  distances_.resize(1);
  table_.assign(std::max<size_t>(table_.size(), size_t{1} << 12), 0);
  last_ = 0;
}

uint32_t RayMasks::Slot(const NodeKey& key) {
  if (2 * blocks_.size() >= table_.size()) Grow();
  const size_t mask = table_.size() - 1;
  for (size_t at = HashOf(key) & mask;; at = (at + 1) & mask) {
    if (table_[at] == 0) {
      table_[at] = static_cast<uint32_t>(blocks_.size());
      blocks_.push_back({key, {}, {}, {}, 0});
      return table_[at];
    }
    if (blocks_[table_[at]].key == key) return table_[at];
  }
}

void RayMasks::Grow() {
  table_.assign(2 * table_.size(), 0);
  const size_t mask = table_.size() - 1;
  for (uint32_t slot = 1; slot < blocks_.size(); ++slot) {
    size_t at = HashOf(blocks_[slot].key) & mask;
    while (table_[at] != 0) at = (at + 1) & mask;
    table_[at] = slot;
  }
}

void RayMasks::MarkDistance(const NodeKey& voxel, int16_t distance) {
  Block& block = At(voxel);
  if (block.distances == 0) {
    block.distances = static_cast<uint32_t>(distances_.size());
    distances_.emplace_back().fill(kNoDistance);
  }
  int16_t& held = distances_[block.distances][static_cast<size_t>(VoxelIndex(voxel.x, voxel.y, voxel.z))];
  const int a = std::abs(static_cast<int>(distance)), b = std::abs(static_cast<int>(held));
  if (held == kNoDistance || a < b || (a == b && distance > held)) held = distance;
}

std::vector<RayMasks::ChunkGroup> RayMasks::ByChunk() const {
  struct Entry {
    uint64_t code;
    int block;
    uint32_t slot;
  };
  std::vector<Entry> order;
  order.reserve(blocks_.size());
  for (uint32_t slot = 1; slot < blocks_.size(); ++slot) {
    const NodeKey& key = blocks_[slot].key;
    order.push_back({ChunkCode(key.Up(kChunkLevel - kBlockLevel)), BlockIndex(key.x, key.y, key.z), slot});
  }
  std::sort(order.begin(), order.end(), [](const Entry& a, const Entry& b) {
    return a.code != b.code ? a.code < b.code : a.block < b.block;
  });
  std::vector<ChunkGroup> groups;
  for (const Entry& entry : order) {
    const NodeKey chunk = ChunkKeyOf(entry.code);
    if (groups.empty() || !(groups.back().chunk == chunk)) groups.push_back({chunk, {}});
    groups.back().blocks.push_back(entry.slot);
  }
  return groups;
}

}  // namespace atlas::mapping
