// Scalar reference of the cone integrator: what one revolution leaves in an occupancy map, voxel by voxel.
//
// Written from the rule alone (thesis 4.5; the comments of mapping/integrator), in plain doubles and without
// its tables, hierarchies or SIMD; it shares data types with the integrator and no code. Stages:
//   1  project and match   cone_reference_image.h     a ray to each cell of the range image
//   2  measurement         cone_reference_image.h     the plane through each return
//   3  free space          cone_reference_free.h      which voxels lie in front of the beams about them
//   4  surface             cone_reference_surface.h   Eq. 4.2 around each return
//   5  write               here                       log-odds update, clamped; blocks collapse
#pragma once

#include <algorithm>
#include <array>
#include <bitset>

#include "mapping/octree/octree.h"
#include "tests/support/cone_reference_free.h"
#include "tests/support/cone_reference_surface.h"

namespace atlas::tests::cone {

/// A block of 8^3 voxels, x fastest.
struct Block {
  std::array<int8_t, mapping::kBlockVoxels> value = {};
  mapping::BlockKind kind = mapping::BlockKind::kUniform;
};

inline mapping::NodeKey VoxelOf(const mapping::NodeKey& block, int i) {
  return {8 * block.x + (i & 7), 8 * block.y + (i >> 3 & 7), 8 * block.z + (i >> 6)};
}

inline Block BlockIn(const mapping::OccupancyOctree& map, const mapping::NodeKey& block) {
  Block b;
  for (int i = 0; i < mapping::kBlockVoxels; ++i) b.value[static_cast<size_t>(i)] = map.At(VoxelOf(block, i));
  const auto* chunk = map.Find(block.Up(3));
  if (chunk != nullptr) b.kind = chunk->Kind(mapping::BlockIndex(block.x & 7, block.y & 7, block.z & 7));
  return b;
}

// --- Stage 5

/// The value after a miss by whole steps, the place of what is occupied kept. Known evidence that cancels
/// is 1.
inline int Lowered(int value, int miss) {
  const int sum = std::max(value - miss, Field::kMin);
  return miss != 0 && sum == 0 ? 1 : sum;
}

/// The value after an update. The two low bits of what is occupied are its place: a return's goes a step
/// towards that of the update, and a voxel that was not occupied takes it.
inline int Updated(int value, int update, int hit) {
  if (update == 0) return value;
  const int old = value & 3, offered = update > 0 ? update & 3 : 0;
  const int place = value <= 0 ? offered : old + (update >= hit ? std::clamp(offered - old, -1, 1) : 0);
  int sum = (value > 0 ? value - old : value) + (update > 0 ? update - offered : update);
  sum = std::clamp(sum, Field::kMin, Field::kMax);
  if (sum > 0) sum = (sum & ~3) | place;
  return sum == 0 ? 1 : sum;
}

/// One scan against an occupancy map.
class ScanReference {
  using Bits = std::bitset<mapping::kBlockVoxels>;
  using Updates = std::array<int, mapping::kBlockVoxels>;

 public:
  ScanReference(const core::SpinEvent& spin, const core::LidarModel& lidar,
                const mapping::IntegratorParams& params, double resolution)
      : params_(params), T_map_lidar_(MiddlePose(spin)) {
    const Beams beams = BeamsOf(lidar);
    image_ = Remap(Project(spin, beams, params), beams, params.remap_stop_rad);
    FindPlanes(&image_);
    free_ = FreeSpaceOf(image_, T_map_lidar_, params, resolution);
    SurfaceUpdates surface(params, resolution);
    surface.Scatter(image_, T_map_lidar_);
    for (const auto& [voxel, update] : surface.values()) {
      const auto& [x, y, z] = voxel;
      updates_[{x >> 3, y >> 3, z >> 3}][static_cast<size_t>((x & 7) + 8 * (y & 7) + 64 * (z & 7))] = update;
    }
  }
  ScanReference(const ScanReference&) = delete;

  /// Of a point from the LiDAR's axis, voxels.
  double AxisDistance(const Vec3& p_voxels) const {
    return (free_.T_lidar_map * (free_.resolution * p_voxels)).head<2>().norm() / free_.resolution;
  }
  double RowPitchRad() const { return image_.beams.mean_row_pitch; }
  /// The block after the scan. @param nudge  voxels, on every voxel's centre where free space is decided.
  Block After(const Block& before, const mapping::NodeKey& key, const Vec3& nudge = Vec3::Zero()) const {
    const bool equal = std::equal(before.value.begin() + 1, before.value.end(), before.value.begin());
    const Updates updates = UpdatesOf(key);
    const bool evidence = std::any_of(updates.begin(), updates.end(), [](int u) { return u != 0; });
    const Cube cube{8.0 * Vec3(key.x, key.y, key.z) + Vec3::Constant(4.0) + nudge, 8.0};
    const bool full = IsFull(free_, cube);
    // A partial miss adds nothing to what is free as a whole already.
    if (!params_.lossless && !full && !evidence && equal && before.value[0] < 0) return before;
    Bits free;
    free.set();
    if (!full) free = FreeIn(before, cube);

    const bool surface = before.kind == mapping::BlockKind::kFine && HasOccupied(before);
    const bool far = BeamsApart(free_, {cube.middle - nudge, 8.0}, 2.0) && free_.max_scale > 1;
    const int miss = Field::StepsOf(params_.miss_nats), hit = Field::StepsOf(params_.hit_nats);
    Block after = before;
    for (int i = 0; i < mapping::kBlockVoxels; ++i) {
      const auto at = static_cast<size_t>(i);
      int loss = free[at] ? miss : 0;
      // Occupied voxels at the edge of free space lose less, and nothing where beams are voxels apart.
      if (!full && (evidence || surface) && free[at] && AtEdge(free, i)) {
        if (far) loss = 0;
        if (!far && before.value[at] > 0) loss = Field::StepsOf(params_.edge_nats);
      }
      const int old = before.value[at];
      after.value[at] = static_cast<int8_t>(updates[at] != 0 ? Updated(old, updates[at], hit)
                                            : evidence       ? Updated(old, -loss, hit)
                                                             : Lowered(old, loss));
    }
    if (!params_.lossless) Collapse(&after);
    return after;
  }

 private:
  static bool HasOccupied(const Block& block) {
    return std::any_of(block.value.begin(), block.value.end(), [](int8_t v) { return v > 0; });
  }
  /// What is free throughout keeps its least free value.
  static void Collapse(Block* block) {
    const int8_t most = *std::max_element(block->value.begin(), block->value.end());
    if (most < 0) block->value.fill(most);
  }

  Updates UpdatesOf(const mapping::NodeKey& key) const {
    const auto found = updates_.find({key.x, key.y, key.z});
    return found == updates_.end() ? Updates{} : found->second;
  }

  /// Blocks that hold a surface are decided voxel by voxel at any distance. So are those near the sensor, and
  /// of them octants as a whole first; octants as free as can be count as free.
  Bits FreeIn(const Block& before, const Cube& block) const {
    if (SeenAt(free_, block.middle).distance > image_.reach + 7.0 * free_.resolution) return {};
    const BlockRule rule =
        RuleOf(free_, block, before.kind == mapping::BlockKind::kFine && HasOccupied(before));
    Bits free;
    const Vec3 corner = block.middle - Vec3::Constant(4.0);
    const int side = rule.scale == 1 ? 4 : rule.scale;
    ForCells(0, 8, side, [&](const Vec3& first) {
      const Cube cell{corner + first + Vec3::Constant(0.5 * side), static_cast<double>(side)};
      if (rule.scale > 1 ? CellIsFree(free_, cell.middle, rule)
                         : IsFull(free_, cell) || Saturated(before, first)) {
        return ForCells(0, side, 1, [&](const Vec3& v) { free.set(IndexOf(first + v)); });
      }
      if (rule.scale > 1) return;
      ForCells(0, side, 1, [&](const Vec3& v) {
        if (CellIsFree(free_, corner + first + v + Vec3::Constant(0.5), rule)) free.set(IndexOf(first + v));
      });
    });
    return free;
  }

  template <typename Visit>
  static void ForCells(int from, int to, int step, const Visit& visit) {
    for (int z = from; z < to; z += step) {
      for (int y = from; y < to; y += step) {
        for (int x = from; x < to; x += step) visit(Vec3(x, y, z));
      }
    }
  }
  static size_t IndexOf(const Vec3& v) { return static_cast<size_t>(v.x() + 8.0 * v.y() + 64.0 * v.z()); }
  static bool Saturated(const Block& block, const Vec3& first) {
    bool all = block.kind == mapping::BlockKind::kFine;
    ForCells(0, 4, 1, [&](const Vec3& v) { all = all && block.value[IndexOf(first + v)] == Field::kMin; });
    return all;
  }
  /// Whether one of the six voxels beside, of the same block, is not free.
  static bool AtEdge(const Bits& free, int i) {
    for (const int step : {1, 8, 64}) {
      const int along = i / step % 8;
      if (along > 0 && !free[static_cast<size_t>(i - step)]) return true;
      if (along < 7 && !free[static_cast<size_t>(i + step)]) return true;
    }
    return false;
  }

  mapping::IntegratorParams params_;
  core::Pose T_map_lidar_;
  RangeImage image_;
  FreeSpace free_;
  std::map<Voxel, Updates> updates_;  ///< by block
};

}  // namespace atlas::tests::cone
