#include "mapping/cloud/surfel_map.h"

#include <cassert>
#include <cmath>

#include "core/rng.h"

namespace atlas::mapping {
namespace {

using core::Vec3f;

constexpr float kOneSurfaceCosine = 0.8f, kMatchCosine = 0.6f;
/// The mean stops moving: a map that follows each scan follows the odometry's drift.
constexpr uint32_t kMostCounted = 100;

std::array<int64_t, 3> SurfelCell(const Vec3f& p, double voxel_m) {
  std::array<int64_t, 3> cell;
  for (int axis = 0; axis < 3; ++axis) {
    cell[static_cast<size_t>(axis)] =
        static_cast<int64_t>(std::floor(static_cast<double>(p[axis]) / voxel_m)) + (1 << 20);
  }
  return cell;
}

uint64_t SurfelKey(int64_t x, int64_t y, int64_t z) {
  constexpr uint64_t kMask = 0x1fffff;
  return ((static_cast<uint64_t>(x) & kMask) << 42) | ((static_cast<uint64_t>(y) & kMask) << 21) |
         (static_cast<uint64_t>(z) & kMask);
}

}  // namespace

SurfelMap::SurfelMap(double voxel_m) : voxel_m_(voxel_m), slots_(1024, kFree) {
  assert(voxel_m > 0.0);
}

uint32_t SurfelMap::Find(uint64_t key) const {
  const size_t mask = slots_.size() - 1;
  for (size_t slot = core::HashCounter(0, key) & mask;; slot = (slot + 1) & mask) {
    if (slots_[slot] == kFree || cells_[slots_[slot]].key == key) return slots_[slot];
  }
}

void SurfelMap::Rehash(size_t slots) {
  slots_.assign(slots, kFree);
  for (uint32_t i = 0; i < cells_.size(); ++i) {
    size_t slot = core::HashCounter(0, cells_[i].key) & (slots - 1);
    while (slots_[slot] != kFree) slot = (slot + 1) & (slots - 1);
    slots_[slot] = i;
  }
}

void SurfelMap::Insert(const Vec3f& p, const Vec3f& normal) {
  const auto at = SurfelCell(p, voxel_m_);
  const uint64_t key = SurfelKey(at[0], at[1], at[2]);
  uint32_t index = Find(key);
  if (index == kFree) {
    index = static_cast<uint32_t>(cells_.size());
    cells_.emplace_back();
    cells_.back().key = key;
    if (2 * cells_.size() > slots_.size()) {
      Rehash(2 * slots_.size());
    } else {
      size_t slot = core::HashCounter(0, key) & (slots_.size() - 1);
      while (slots_[slot] != kFree) slot = (slot + 1) & (slots_.size() - 1);
      slots_[slot] = index;
    }
  }
  for (Surfel& surfel : cells_[index].surfels) {
    if (surfel.count == 0) {
      surfel = {p, normal, 1};
      return;
    }
    if (surfel.normal.dot(normal) < kOneSurfaceCosine) continue;
    if (surfel.count >= kMostCounted) return;
    const float share = 1.0f / static_cast<float>(++surfel.count);
    surfel.mean += share * (p - surfel.mean);
    surfel.normal = (surfel.normal + share * (normal - surfel.normal)).normalized();
    return;
  }
}

std::optional<Surfel> SurfelMap::Nearest(const Vec3f& p, const Vec3f& normal, float max_distance_m) const {
  const auto at = SurfelCell(p, voxel_m_);
  const Surfel* best = nullptr;
  float best_sq = max_distance_m * max_distance_m;
  for (int64_t x = at[0] - 1; x <= at[0] + 1; ++x) {
    for (int64_t y = at[1] - 1; y <= at[1] + 1; ++y) {
      for (int64_t z = at[2] - 1; z <= at[2] + 1; ++z) {
        const uint32_t index = Find(SurfelKey(x, y, z));
        if (index == kFree) continue;
        for (const Surfel& surfel : cells_[index].surfels) {
          if (surfel.count == 0) break;
          const float distance_sq = (p - surfel.mean).squaredNorm();
          if (distance_sq >= best_sq || surfel.normal.dot(normal) < kMatchCosine) continue;
          best_sq = distance_sq;
          best = &surfel;
        }
      }
    }
  }
  if (best == nullptr) return std::nullopt;
  return *best;
}

void SurfelMap::Crop(const Vec3f& p, float radius_m) {
  const auto far = [&](const Cell& cell) {
    return (cell.surfels[0].mean - p).squaredNorm() > radius_m * radius_m;
  };
  if (std::erase_if(cells_, far) > 0) Rehash(slots_.size());
}

}  // namespace atlas::mapping
