// Cells of one block against the beams, 16 at a time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/integrator/cell_tests.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "mapping/integrator/fill_kernels.h"
#include "mapping/integrator/project-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atlas::mapping {
namespace HWY_NAMESPACE {

constexpr float kBlockRadius = 6.9283f;  ///< voxels, circumscribed
constexpr float kPierceRadius = 0.71f;   ///< cells: a beam that passes this near to the middle pierces it
constexpr float kFarRadii2 = 12.0f;      ///< squared, in block radii from the axis: tangents stay below 0.45
constexpr float kWindowShare = 0.75f;    ///< of a cell's width that the veto window must cover

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

/// The images that a block is tested against.
struct CellImages {
  const float *own, *around;
  int pitch, columns;
  int row_offset;      ///< from a cell's upper row to the stored row of its window
  int columns_before;  ///< of the window, left of the cell's left column
  float rows_end;      ///< rows - 0.5
  float pierce2;       ///< squared distance, metres
  const ScanImage* image;
};

/// Whether the nearest beam itself passes through the cell.
HWY_INLINE MF Pierced(DF d, const CellImages& images, const GridPoint& p, VF x, VF y, VI row, VI column) {
  const DI di;
  const ScanImage& image = *images.image;
  const VI turn = hn::Set(di, images.columns);
  const VI wrapped = hn::IfThenElse(hn::Lt(column, turn), column, hn::Sub(column, turn));
  const VI cell = hn::Add(hn::Mul(row, turn), wrapped);
  const VF du = hn::GatherIndex(d, image.du.data(), cell), dv = hn::GatherIndex(d, image.dv.data(), cell);
  const VF row_pitch = hn::GatherIndex(d, image.grid->row_pitch_rad.data(), row);
  const VF flat = hn::Sqrt(hn::Add(hn::Mul(x, x), hn::Mul(y, y)));
  const VF pitch = hn::Set(d, static_cast<float>(image.grid->column_pitch_rad));
  const VF eu = hn::Mul(hn::Mul(hn::Sub(hn::Sub(p.u, hn::ConvertTo(d, column)), du), pitch), flat);
  const VF ev = hn::Mul(hn::Mul(hn::Sub(hn::Sub(p.v, hn::ConvertTo(d, row)), dv), row_pitch), p.distance);
  return hn::Lt(hn::Add(hn::Mul(eu, eu), hn::Mul(ev, ev)), hn::Set(d, images.pierce2));
}

/// Bits of the free cells among Lanes(d); sets *pierced where the last rule decided.
HWY_INLINE uint32_t TestVector(DF d, const CellImages& images, const GridPoint& p, VF x, VF y,
                               bool* pierced) {
  const DI di;
  const VF half = hn::Set(d, 0.5f), one = hn::Set(d, 1.0f);
  MF in = hn::And(hn::Ge(p.v, hn::Neg(half)), hn::Lt(p.v, hn::Set(d, images.rows_end)));
  if (hn::AllFalse(d, in)) return 0;
  const VF v = hn::IfThenElseZero(in, p.v);
  const VI pitch = hn::Set(di, images.pitch);
  const VI row = FloorPositive(di, hn::Add(v, half)), column = FloorPositive(di, hn::Add(p.u, half));
  const VF own = hn::GatherIndex(d, images.own, hn::Add(hn::Mul(row, pitch), column));
  in = hn::And(in, hn::Lt(p.distance, own));
  if (hn::AllFalse(d, in)) return 0;

  const VI upper = hn::Add(FloorPositive(di, hn::Add(v, one)), hn::Set(di, images.row_offset - 1));
  VI left = hn::Sub(FloorPositive(di, p.u), hn::Set(di, images.columns_before));
  left = hn::IfThenElse(hn::Lt(left, hn::Zero(di)), hn::Add(left, hn::Set(di, images.columns)), left);
  const VF around = hn::GatherIndex(d, images.around, hn::Add(hn::Mul(upper, pitch), left));
  const MF clear = hn::Lt(p.distance, around);
  const MF doubtful = hn::AndNot(clear, in);
  if (hn::AllFalse(d, doubtful)) return BitsOf(d, in);
  const MF through = hn::And(doubtful, Pierced(d, images, p, x, y, row, column));
  if (!hn::AllFalse(d, through)) *pierced = true;
  return BitsOf(d, hn::Or(hn::And(in, clear), through));
}

/// Offsets of the 16 cells of a group from its first, and the steps from group to group.
struct Lattice {
  float lane[3][kGroup];
  float first[3];
  float step_y[3], step_z[3];  ///< groups_y a layer, `layers` layers
  int groups_y, layers;
};

template <typename Projector>
HWY_INLINE bool TestLattice(const CellImages& images, const Lattice& lattice, const Projector& projector,
                            uint64_t* out, bool by_layer) {
  const DF d;
  const size_t lanes = hn::Lanes(d);
  const uint32_t lane_bits = static_cast<uint32_t>((uint64_t{1} << lanes) - 1);
  bool pierced = false;
  for (int z = 0; z < lattice.layers; ++z) {
    uint64_t layer = 0;
    for (int j = 0; j < lattice.groups_y; ++j) {
      float at[3];
      for (int c = 0; c < 3; ++c) {
        at[c] = lattice.first[c] + static_cast<float>(j) * lattice.step_y[c] +
                static_cast<float>(z) * lattice.step_z[c];
      }
      uint64_t bits = 0;
      for (size_t i = 0; i < kGroup; i += lanes) {
        const VF x = hn::Add(hn::Set(d, at[0]), hn::LoadU(d, lattice.lane[0] + i));
        const VF y = hn::Add(hn::Set(d, at[1]), hn::LoadU(d, lattice.lane[1] + i));
        const VF zz = hn::Add(hn::Set(d, at[2]), hn::LoadU(d, lattice.lane[2] + i));
        const GridPoint p = projector.Project(d, x, y, zz);
        bits |= static_cast<uint64_t>(TestVector(d, images, p, x, y, &pierced) & lane_bits) << i;
      }
      layer |= bits << (16 * j);
    }
    if (by_layer) {
      out[z] = layer;
    } else {
      out[0] |= layer << (16 * z);
    }
  }
  return pierced;
}

/// `turn` rotates about the LiDAR's z (cosine, sine).
HWY_INLINE Lattice LatticeOf(const ScanFrame& frame, const NodeKey& corner, int scale, const float turn[2]) {
  Lattice lattice;
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

HWY_INLINE CellImages ImagesFor(const ScanImage& image, const ScanFrame& frame, float distance, int scale) {
  const size_t s = scale == 1 ? 0 : scale == 2 ? 1 : 2;
  size_t level = 1;
  if (scale == 1) {
    const float nearest = std::max(distance - 0.5f * kBlockRadius * frame.resolution_m, 0.3f);
    const float width = frame.resolution_m / (static_cast<float>(image.grid->min_pitch_rad) * nearest);
    while (level + 1 < ScanImage::kLevels && static_cast<float>(1 << level) < kWindowShare * width + 1.0f)
      ++level;
  }
  CellImages images;
  images.image = &image;
  images.own = image.own[s].data();
  images.around = level == 1 ? image.surround[s].data() : image.window[level].data();
  images.pitch = image.pitch;
  images.columns = image.columns;
  images.row_offset = image.window_rows[level] / 2;
  images.columns_before = image.window_columns[level] / 2 - 1;
  images.rows_end = static_cast<float>(image.rows) - 0.5f;
  const float radius = kPierceRadius * static_cast<float>(scale) * frame.resolution_m;
  images.pierce2 = radius * radius;
  return images;
}

bool TestBlockCells(const ScanImage& image, const ScanFrame& frame, const NodeKey& corner, int scale,
                    FreeCells* out) {
  const BeamGrid& grid = *image.grid;
  float center[3];
  frame.ToLidar(static_cast<float>(corner.x + 4), static_cast<float>(corner.y + 4),
                static_cast<float>(corner.z + 4), center);
  const float flat2 = center[0] * center[0] + center[1] * center[1];
  const float distance = std::sqrt(flat2 + center[2] * center[2]);
  const float radius = kBlockRadius * frame.resolution_m;
  const CellImages images = ImagesFor(image, frame, distance, scale);
  uint64_t* bits = out->voxels.data();
  for (int i = 0; i < 8; ++i) bits[i] = 0;
  if (flat2 < kFarRadii2 * radius * radius) {
    const float still[2] = {1.0f, 0.0f};
    return TestLattice(images, LatticeOf(frame, corner, scale, still), NearProjector{grid}, bits, scale == 1);
  }
  const float flat = std::sqrt(flat2);
  const float turn[2] = {center[0] / flat, center[1] / flat};
  const float sa = radius / distance, ca = std::sqrt(1.0f - sa * sa);
  const float se = center[2] / distance, ce = flat / distance;
  FarProjector projector;
  projector.columns_per_rad = static_cast<float>(1.0 / grid.column_pitch_rad);
  projector.columns = static_cast<float>(grid.columns);
  const DF d;
  projector.u_center = hn::GetLane(ColumnOf(d, grid, hn::Set(d, center[0]), hn::Set(d, center[1])));
  FillPieces(grid, se * ca - ce * sa, se * ca + ce * sa, &projector);
  return TestLattice(images, LatticeOf(frame, corner, scale, turn), projector, bits, scale == 1);
}

}  // namespace HWY_NAMESPACE
}  // namespace atlas::mapping
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace atlas::mapping {
namespace {
HWY_EXPORT(TestBlockCells);
}  // namespace

bool TestCells(const ScanImage& image, const ScanFrame& frame, const NodeKey& corner, int scale,
               FreeCells* out) {
  return HWY_DYNAMIC_DISPATCH(TestBlockCells)(image, frame, corner, scale, out);
}

}  // namespace atlas::mapping
#endif
