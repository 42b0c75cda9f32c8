// Cells of a block to grid coordinates, for each SIMD target.
#if defined(ATLAS_MAPPING_INTEGRATOR_BLOCK_PROJECT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATLAS_MAPPING_INTEGRATOR_BLOCK_PROJECT_INL_H_
#undef ATLAS_MAPPING_INTEGRATOR_BLOCK_PROJECT_INL_H_
#else
#define ATLAS_MAPPING_INTEGRATOR_BLOCK_PROJECT_INL_H_
#endif

#include "mapping/integrator/fill_kernels.h"
#include "mapping/integrator/project-inl.h"

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

/// Offsets of the 16 cells of a group from its first, and the steps from group to group.
struct Lattice {
  float lane[3][kGroup];
  float first[3];
  float step_y[3], step_z[3];  ///< groups_y a layer, `layers` layers
  int groups_y, layers;
  float turn[2];  ///< of the frame about z (cosine, sine)
};

/// `turn` rotates about the LiDAR's z (cosine, sine).
HWY_INLINE Lattice LatticeOf(const ScanFrame& frame, const NodeKey& corner, int scale, const float turn[2]) {
  Lattice lattice;
  lattice.turn[0] = turn[0];
  lattice.turn[1] = turn[1];
  const auto turned = [&](const float v[3], float out[3]) {
    out[0] = v[0] * turn[0] + v[1] * turn[1];
    out[1] = v[1] * turn[0] - v[0] * turn[1];
    out[2] = v[2];
  };
  float axis[3][3];
  for (int a = 0; a < 3; ++a) turned(frame.axis[a], axis[a]);
  const float middle = 0.5f * static_cast<float>(scale);
  float first[3];
  frame.ToLidar(static_cast<float>(corner.x) + middle, static_cast<float>(corner.y) + middle,
                static_cast<float>(corner.z) + middle, first);
  turned(first, lattice.first);
  // Cells along x, y, z of a group: 8 x 2 x 1, 4 x 4 x 1 or 2 x 2 x 2 (twice over).
  const int along_x = 8 / scale, along_y = scale == 1 ? 2 : scale == 2 ? 4 : 2;
  for (int i = 0; i < 16; ++i) {
    const int x = i % along_x, y = i / along_x % along_y, z = scale == 4 ? i / 4 % 2 : 0;
    for (int c = 0; c < 3; ++c) {
      lattice.lane[c][i] = static_cast<float>(scale * x) * axis[0][c] +
                           static_cast<float>(scale * y) * axis[1][c] +
                           static_cast<float>(scale * z) * axis[2][c];
    }
  }
  for (int c = 0; c < 3; ++c) {
    lattice.step_y[c] = 2.0f * axis[1][c];
    lattice.step_z[c] = static_cast<float>(scale) * axis[2][c];
  }
  lattice.groups_y = scale == 1 ? 4 : 1;
  lattice.layers = scale == 1 ? 8 : scale == 2 ? 4 : 1;
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

/// Calls test(lattice, projector) with the projector that suits the block's place.
template <typename Test>
HWY_INLINE void WithProjector(const ScanImage& image, const ScanFrame& frame, const NodeKey& corner,
                              int scale, const Test& test) {
  const BeamGrid& grid = *image.grid;
  float center[3];
  frame.ToLidar(static_cast<float>(corner.x + 4), static_cast<float>(corner.y + 4),
                static_cast<float>(corner.z + 4), center);
  const float flat2 = center[0] * center[0] + center[1] * center[1];
  const float distance = std::sqrt(flat2 + center[2] * center[2]);
  const float radius = kBlockRadius * frame.resolution_m;
  if (flat2 < kFarRadii2 * radius * radius) {
    const float still[2] = {1.0f, 0.0f};
    test(LatticeOf(frame, corner, scale, still), NearProjector{grid}, distance);
    return;
  }
  const float flat = std::sqrt(flat2);
  const float turn[2] = {center[0] / flat, center[1] / flat};
  const float sa = radius / distance, ca = std::sqrt(1.0f - sa * sa);
  const float se = center[2] / distance, ce = flat / distance;
  const DF d;
  FarProjector projector;
  projector.columns_per_rad = static_cast<float>(1.0 / grid.column_pitch_rad);
  projector.columns = static_cast<float>(grid.columns);
  projector.u_center = hn::GetLane(ColumnOf(d, grid, hn::Set(d, center[0]), hn::Set(d, center[1])));
  FillPieces(grid, se * ca - ce * sa, se * ca + ce * sa, &projector);
  test(LatticeOf(frame, corner, scale, turn), projector, distance);
}

}  // namespace HWY_NAMESPACE
}  // namespace atlas::mapping
HWY_AFTER_NAMESPACE();

#endif
