// Cells of a block to grid coordinates, for each SIMD target.
#if defined(ATLAS_MAPPING_INTEGRATOR_BLOCK_PROJECT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATLAS_MAPPING_INTEGRATOR_BLOCK_PROJECT_INL_H_
#undef ATLAS_MAPPING_INTEGRATOR_BLOCK_PROJECT_INL_H_
#else
#define ATLAS_MAPPING_INTEGRATOR_BLOCK_PROJECT_INL_H_
#endif

#include <cmath>

#include "mapping/integrator/free_space/fill_kernels.h"
#include "mapping/integrator/projection/project-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atlas::mapping {
namespace HWY_NAMESPACE {

constexpr float kBlockRadius = 6.9283f;  ///< voxels, circumscribed
constexpr float kFarRadii2 = 12.0f;      ///< squared, in block radii from the axis: tangents stay below 0.45

struct GridPoint {
  VF u, v, distance;
};

/// Anywhere, full arc tangent.
struct NearProjector {
  const BeamGrid& grid;
  HWY_INLINE GridPoint Project(DF d, VF x, VF y, VF z) const {
    const VF flat2 = hn::Add(hn::Mul(x, x), hn::Mul(y, y));
    const VF distance = hn::Max(hn::Sqrt(hn::Add(flat2, hn::Mul(z, z))), hn::Set(d, 1e-6f));
    return {ColumnOf(d, grid, x, y), RowOf(d, grid, hn::Div(z, distance)), distance};
  }
};

/// In a frame turned so that x points at the block: short arc tangent, and rows from 16 pieces over the
/// block's own elevations.
struct FarProjector {
  float u_center, columns_per_rad, columns;
  float sine_first, pieces_per_sine;
  alignas(64) float offset[kGroup], slope[kGroup];  ///< row = offset + slope * sine on a piece

  HWY_INLINE VF Row(DF d, VF sine) const {
    const DI di;
    VF x = hn::Mul(hn::Sub(sine, hn::Set(d, sine_first)), hn::Set(d, pieces_per_sine));
    x = hn::Min(hn::Max(x, hn::Zero(d)), hn::Set(d, static_cast<float>(kGroup) - 0.5f));
    const VI piece = FloorPositive(di, x);
    VF a, b;
    if constexpr (hn::MaxLanes(DF()) == kGroup) {
      const auto index = hn::IndicesFromVec(d, piece);
      a = hn::TableLookupLanes(hn::Load(d, offset), index);
      b = hn::TableLookupLanes(hn::Load(d, slope), index);
    } else {
      a = hn::GatherIndex(d, offset, piece);
      b = hn::GatherIndex(d, slope, piece);
    }
    return hn::Add(a, hn::Mul(b, sine));
  }
  HWY_INLINE GridPoint Project(DF d, VF x, VF y, VF z) const {
    const VF flat2 = hn::Add(hn::Mul(x, x), hn::Mul(y, y));
    const VF distance = hn::Sqrt(hn::Add(flat2, hn::Mul(z, z)));
    const VF inverse = hn::Div(hn::Set(d, 1.0f), hn::Mul(x, distance));
    const VF tangent = hn::Mul(hn::Mul(y, distance), inverse), sine = hn::Mul(hn::Mul(z, x), inverse);
    const VF turn = hn::Mul(AtanOfSmall(d, tangent), hn::Set(d, columns_per_rad));
    return {WrapColumn(d, hn::Add(turn, hn::Set(d, u_center)), columns), Row(d, sine), distance};
  }
};

/// Groups of 16 cells of a block in a frame turned about the LiDAR's z.
struct Lattice {
  alignas(64) float lane[3][kGroup];  ///< offsets from a group's first cell
  float first[3];
  float step_y[3], step_z[3];  ///< from group to group of a layer, and from layer to layer
  float turn[2];               ///< cosine, sine
};

HWY_INLINE void Turn(const float turn[2], const float v[3], float out[3]) {
  out[0] = v[0] * turn[0] + v[1] * turn[1];
  out[1] = v[1] * turn[0] - v[0] * turn[1];
  out[2] = v[2];
}

/// @param corner  of the first cell, `scale` voxels wide.
HWY_INLINE Lattice LatticeOf(const ScanFrame& frame, const ScanFrame::Lanes& lanes, const NodeKey& corner,
                             int scale, const float turn[2]) {
  const DF d;
  Lattice lattice;
  lattice.turn[0] = turn[0];
  lattice.turn[1] = turn[1];
  const float middle = 0.5f * static_cast<float>(scale);
  float first[3];
  frame.ToLidar(static_cast<float>(corner.x) + middle, static_cast<float>(corner.y) + middle,
                static_cast<float>(corner.z) + middle, first);
  Turn(turn, first, lattice.first);
  Turn(turn, frame.axis[1], lattice.step_y);
  Turn(turn, frame.axis[2], lattice.step_z);
  for (int c = 0; c < 3; ++c) {
    lattice.step_y[c] *= 2.0f;
    lattice.step_z[c] *= static_cast<float>(scale);
  }
  const VF cosine = hn::Set(d, turn[0]), sine = hn::Set(d, turn[1]);
  for (size_t i = 0; i < kGroup; i += hn::Lanes(d)) {
    const VF x = hn::Load(d, lanes.offset[0] + i), y = hn::Load(d, lanes.offset[1] + i);
    hn::Store(hn::Add(hn::Mul(x, cosine), hn::Mul(y, sine)), d, lattice.lane[0] + i);
    hn::Store(hn::Sub(hn::Mul(y, cosine), hn::Mul(x, sine)), d, lattice.lane[1] + i);
    hn::Store(hn::Load(d, lanes.offset[2] + i), d, lattice.lane[2] + i);
  }
  return lattice;
}

HWY_INLINE void FillPieces(const BeamGrid& grid, float sine_low, float sine_high, FarProjector* projector) {
  const DF d;
  projector->sine_first = sine_low;
  const float width = (sine_high - sine_low) * (1.0f / static_cast<float>(kGroup));
  projector->pieces_per_sine = 1.0f / width;
  for (size_t i = 0; i < kGroup; i += hn::Lanes(d)) {
    const VF index = hn::Iota(d, static_cast<float>(i));
    const VF w = hn::Set(d, width);
    const VF s0 = hn::Add(hn::Set(d, sine_low), hn::Mul(index, w));
    const VF s1 = hn::Add(s0, w);
    const VF v0 = RowOf(d, grid, s0), v1 = RowOf(d, grid, s1);
    const VF slope = hn::Mul(hn::Sub(v1, v0), hn::Set(d, projector->pieces_per_sine));
    hn::StoreU(slope, d, projector->slope + i);
    hn::StoreU(hn::Sub(v0, hn::Mul(slope, s0)), d, projector->offset + i);
  }
}

/// Where a block (or part of one) lies: its middle, and how to turn and project what is in it.
struct Place {
  float distance, flat, turn[2], center[3];
  bool near;  ///< too near to the axis for the short polynomials
};
HWY_INLINE Place PlaceOf(const ScanFrame& frame, const NodeKey& corner, int side) {
  Place place;
  const float middle = 0.5f * static_cast<float>(side);
  frame.ToLidar(static_cast<float>(corner.x) + middle, static_cast<float>(corner.y) + middle,
                static_cast<float>(corner.z) + middle, place.center);
  const float flat2 = place.center[0] * place.center[0] + place.center[1] * place.center[1];
  place.distance = std::sqrt(flat2 + place.center[2] * place.center[2]);
  place.flat = std::sqrt(flat2);
  const float radius = kBlockRadius * frame.resolution_m;
  place.near = flat2 < kFarRadii2 * radius * radius;
  place.turn[0] = place.near ? 1.0f : place.center[0] / place.flat;
  place.turn[1] = place.near ? 0.0f : place.center[1] / place.flat;
  return place;
}

/// @param radius  of the sphere around the place that holds everything projected.
HWY_INLINE void SetProjector(const BeamGrid& grid, const Place& place, float radius,
                             FarProjector* projector) {
  const DF d;
  const float sa = radius / place.distance, ca = std::sqrt(1.0f - sa * sa);
  const float se = place.center[2] / place.distance, ce = place.flat / place.distance;
  projector->columns_per_rad = static_cast<float>(1.0 / grid.column_pitch_rad);
  projector->columns = static_cast<float>(grid.columns);
  projector->u_center =
      hn::GetLane(ColumnOf(d, grid, hn::Set(d, place.center[0]), hn::Set(d, place.center[1])));
  FillPieces(grid, se * ca - ce * sa, se * ca + ce * sa, projector);
}

}  // namespace HWY_NAMESPACE
}  // namespace atlas::mapping
HWY_AFTER_NAMESPACE();

#endif
