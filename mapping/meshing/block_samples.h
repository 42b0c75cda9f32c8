// The field at the voxel centres of a block and three voxels around it, as one dense cube.
#pragma once

#include <array>
#include <cmath>

#include "mapping/octree/octree.h"

namespace atlas::mapping {

/// A chunk and the 26 around it; null where there is none. Index dx + 3 dy + 9 dz, each in [0, 3).
template <typename Field>
using ChunkNeighbours = std::array<const typename Octree<Field>::Chunk*, 27>;

/// Sign of a voxel against the surface: positive outside, zero or negative inside, NaN unknown. Signed
/// distance in voxels; log-odds in units of the upper clamp, where voxels at the lower clamp, whose evidence
/// is cut off earlier, count as much as those at the upper one: between two saturated ends the surface lies
/// in the middle.
inline float SampleOf(TsdfField::Value v) {
  constexpr auto kVoxels = static_cast<float>(TsdfField::kWidestTruncationVoxels / 32767.0);
  return v.weight == 0 ? std::nanf("") : kVoxels * static_cast<float>(v.distance);
}
inline float SampleOf(OccupancyField::Value v) {
  if (v == 0) return std::nanf("");
  if (v == OccupancyField::kMin) return 1.0f;
  return static_cast<float>(v) / -static_cast<float>(OccupancyField::kMax);
}
inline bool IsInside(float sample) {
  return sample <= 0.0f;
}
inline bool IsKnown(float sample) {
  return sample == sample;
}
/// Of an occupancy sample inside (OccupancyField::PlaceOf).
inline float PlaceOf(float sample) {
  const auto value = std::lround(sample * -static_cast<float>(OccupancyField::kMax));
  return static_cast<float>(OccupancyField::PlaceOf(static_cast<int8_t>(value)));
}

/// Coordinates are voxels from the block's first one, in [kBegin, kEnd) on each axis.
template <typename Field>
class BlockSamples {
 public:
  static constexpr int kBegin = -3, kEnd = 12;

  /// @pre `around` are the chunk of `block` (in the middle) and its neighbours in `map`.
  void Gather(const Octree<Field>& map, const ChunkNeighbours<Field>& around, int block);

  float At(int x, int y, int z) const {
    return sample_[static_cast<size_t>((x - kBegin) + kRow * ((y - kBegin) + kRow * (z - kBegin)))];
  }
  /// Between voxel centres, trilinear over the known ones; NaN among unknown. @pre one voxel inside the
  /// bounds.
  float Between(const core::Vec3f& p) const;
  /// The sample at the scale it is stored: coarse cells are interpolated between their centres, keeping the
  /// sign of the cell, so that they make slopes and not steps. @pre x, y, z in [0, 9).
  float AtScale(int x, int y, int z) const { return ScaleAt(x, y, z) == 1 ? At(x, y, z) : Slope(x, y, z); }
  /// Side of the stored cell in voxels, 1 or 2.
  int ScaleAt(int x, int y, int z) const {
    return scale_[static_cast<size_t>((x >> 3) + 1 + 3 * ((y >> 3) + 1) + 9 * ((z >> 3) + 1))];
  }

 private:
  static constexpr int kRow = 16;
  float Slope(int x, int y, int z) const;
  float CellMean(int cx, int cy, int cz) const;

  std::array<float, static_cast<size_t>(kRow) * kRow * kRow> sample_;
  std::array<int8_t, 27> scale_;
};

extern template class BlockSamples<OccupancyField>;
extern template class BlockSamples<TsdfField>;

}  // namespace atlas::mapping
