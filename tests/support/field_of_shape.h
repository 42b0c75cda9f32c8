// Octrees filled straight from a closed form, without a sensor.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>

#include "mapping/octree/octree.h"

namespace atlas::tests {

/// Makes all summaries current; uniform blocks are found first where asked for.
template <typename Field>
void Refresh(mapping::Octree<Field>* map, bool collapse = false) {
  for (const auto& [key, mask] : map->TakeChanges()) {
    auto* chunk = map->Find(key);
    if (collapse) map->CollapseEqual(chunk, mask, 0);
    map->Propagate(chunk, mask);
  }
}

/// Sets every voxel whose centre lies in `box` to `value(centre)` (unknown values are left out), then mends
/// the summaries.
template <typename Field>
void FillOctree(const core::Box3& box,
                const std::function<typename Field::Value(const core::Vec3& center)>& value,
                mapping::Octree<Field>* map) {
  const mapping::NodeKey first = map->KeyAt(box.min), last = map->KeyAt(box.max);
  for (int z = first.z; z <= last.z; ++z) {
    for (int y = first.y; y <= last.y; ++y) {
      for (int x = first.x; x <= last.x; ++x) {
        const auto v = value(map->CenterOf({x, y, z}));
        if (Field::Known(v)) map->Set({x, y, z}, v);
      }
    }
  }
  Refresh(map);
}

/// Log-odds and, of occupied voxels, how much of the voxel lies behind the surface, as the octree holds them.
inline mapping::OccupancyField::Value OccupancyAt(long units, double behind) {
  using Field = mapping::OccupancyField;
  units = std::clamp<long>(units, Field::kMin, Field::kMax);
  if (units < 0) return static_cast<Field::Value>(units);
  const long place = std::clamp<long>(static_cast<long>(4.0 * behind), 0, 3);
  return static_cast<Field::Value>(std::max<long>(units / 4 * 4 + place, 1));
}

/// A signed distance as the octree holds it, unknown from `band_m` on.
inline mapping::TsdfField::Value TsdfAt(double distance_m, double band_m, double resolution_m) {
  if (std::abs(distance_m) >= band_m) return {};
  const double units = distance_m / mapping::TsdfField::UnitM(resolution_m);
  return {static_cast<int16_t>(std::lround(std::clamp(units, -32767.0, 32767.0))), 10};
}

}  // namespace atlas::tests
