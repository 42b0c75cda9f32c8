// Cells of a far cube against the beams, where first order places them (CubeSlopes), for each SIMD target.
#if defined(ATLAS_MAPPING_INTEGRATOR_SMOOTH_CELLS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATLAS_MAPPING_INTEGRATOR_SMOOTH_CELLS_INL_H_
#undef ATLAS_MAPPING_INTEGRATOR_SMOOTH_CELLS_INL_H_
#else
#define ATLAS_MAPPING_INTEGRATOR_SMOOTH_CELLS_INL_H_
#endif

#include "mapping/integrator/free_space/cube-inl.h"

HWY_BEFORE_NAMESPACE();
#undef ATLAS_IMAGE_WINDOWS
namespace atlas::mapping {
namespace HWY_NAMESPACE {

constexpr float kBeforeEnd = 1e-3f;  ///< rows: what floats of up to 1024 rows tell apart

/// The images that a block is tested against.
struct CellImages {
  const float *own, *around;
  float pitch;
  int columns;
  float row_offset;    ///< from the row above a cell to the stored row of its window
  int columns_before;  ///< of the window, left of the cell's left column
  float rows_end;      ///< rows - 0.5
  float pierce2;       ///< squared distance, metres
  const FreeSpaceTables* tables;
};

/// A bit each of up to 64 cells.
struct GroupBits {
  uint64_t clear, pierced;
};

/// Of a cube, from CubeSlopes.
struct Slopes {
  float u, v, distance, du[3], dv[3], ddistance[3], metres_per_column, metres_per_row;
  int first_column, first_row, window;
};
HWY_INLINE Slopes SlopesOf(const CubeSlopes& all, size_t lane) {
  Slopes s;
  s.u = all.u[lane];
  s.v = all.v[lane];
  s.distance = all.distance[lane];
  for (size_t a = 0; a < 3; ++a) {
    s.du[a] = all.du[a][lane];
    s.dv[a] = all.dv[a][lane];
    s.ddistance[a] = all.ddistance[a][lane];
  }
  s.metres_per_column = all.metres_per_column[lane];
  s.metres_per_row = all.metres_per_row[lane];
  s.first_column = all.first_column[lane];
  s.first_row = all.first_row[lane];
  s.window = all.window[lane];
  return s;
}

/// Looks values up by row and column of an image, anywhere.
struct WholeImage {
  const float* image;
  VF pitch;
  HWY_INLINE WholeImage(DF d, const float* first, float row_pitch, const Slopes&, int)
      : image(first), pitch(hn::Set(d, row_pitch)) {}
  HWY_INLINE VF At(DF d, VF row, VF column) const {
    // Exact: images have fewer than 2^24 cells.
    return hn::GatherIndex(d, image, hn::ConvertTo(DI(), hn::Add(hn::Mul(row, pitch), column)));
  }
};

#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3
#define ATLAS_IMAGE_WINDOWS 1
/// The same in the few cells that a far cube can meet, held in registers. @param kWindow  of CubeSlopes.
template <int kWindow>
struct ImageWindow {
  static constexpr int kRows = CubeSlopes::kRows[kWindow], kColumns = CubeSlopes::kColumns[kWindow];
  static constexpr int kPairs = kRows * kColumns / 32;
  VF first[kPairs], second[kPairs], origin;  ///< 16 cells each, first[0], second[0], first[1] and so on

  HWY_INLINE ImageWindow(DF d, const float* image, float row_pitch, const Slopes& s, int least_row) {
    const int first_row = std::max(s.first_row, least_row);
    const auto pitch = static_cast<ptrdiff_t>(row_pitch);
    const float* const corner = image + first_row * pitch + s.first_column;
    const auto row = [&](int k) { return corner + k * pitch; };
    for (int i = 0; i < kPairs; ++i) {
      if constexpr (kColumns == kGroup) {
        first[i] = hn::LoadU(d, row(2 * i));
        second[i] = hn::LoadU(d, row(2 * i + 1));
      } else {
        const hn::Half<DF> dh;
        first[i] = hn::Combine(d, hn::LoadU(dh, row(4 * i + 1)), hn::LoadU(dh, row(4 * i)));
        second[i] = hn::Combine(d, hn::LoadU(dh, row(4 * i + 3)), hn::LoadU(dh, row(4 * i + 2)));
      }
    }
    origin = hn::Set(d, static_cast<float>(first_row * kColumns + s.first_column));
  }
  HWY_INLINE VF At(DF d, VF row, VF column) const {
    const DI di;
    const VF columns = hn::Set(d, static_cast<float>(kColumns));
    const VI at = hn::ConvertTo(di, hn::Sub(hn::Add(hn::Mul(row, columns), column), origin));
    // The low five bits choose in a pair, the others the pair.
    VF out{_mm512_permutex2var_ps(first[0].raw, at.raw, second[0].raw)};
    for (int i = 1; i < kPairs; ++i) {
      const VF here{_mm512_permutex2var_ps(first[i].raw, at.raw, second[i].raw)};
      out = hn::IfThenElse(hn::RebindMask(d, hn::Gt(at, hn::Set(di, 32 * i - 1))), here, out);
    }
    return out;
  }
};
#endif

/// Which cells at these grid coordinates their own beam pierces.
HWY_INLINE MF PiercedByOwn(DF d, const CellImages& images, const Slopes& s, VF u, VF v) {
  const DI di;
  const VF half = hn::Set(d, 0.5f);
  const VF row = hn::Floor(hn::Add(v, half)), column = hn::Floor(hn::Add(u, half));
  const VI cell =
      hn::ConvertTo(di, hn::Add(hn::Mul(row, hn::Set(d, static_cast<float>(images.columns))), column));
  const Offsets ray = UnpackOffsets(d, hn::GatherIndex(di, images.tables->image->offset.data(), cell));
  const VF eu = hn::Mul(hn::Sub(hn::Sub(u, column), ray.u), hn::Set(d, s.metres_per_column));
  const VF ev = hn::Mul(hn::Sub(hn::Sub(v, row), ray.v), hn::Set(d, s.metres_per_row));
  return hn::Lt(hn::Add(hn::Mul(eu, eu), hn::Mul(ev, ev)), hn::Set(d, images.pierce2));
}

/// 4^3 cells of `side` voxels about the middle of a cube where its slopes hold: as TestGroups, without a seam
/// to mind.
template <typename Lookup>
HWY_INLINE GroupBits TestSmoothBy(const CellImages& images, const Slopes& s, float side) {
  const DF d;
  const size_t lanes = hn::Lanes(d);
  if (s.first_row >= images.tables->image->rows)
    return {0, 0};  // all below the grid, and windows would leave the tables
  const VF half = hn::Set(d, 0.5f);
  // From a cell to the window around it.
  const float* const around_first = images.around +
                                    static_cast<ptrdiff_t>((1.0f + images.row_offset) * images.pitch) -
                                    images.columns_before;
  const Lookup own(d, images.own, images.pitch, s, 0);
  const Lookup around(d, around_first, images.pitch, s, -1);
  alignas(64) static constexpr float kAlongX[kGroup] = {-1.5f, -0.5f, 0.5f, 1.5f, -1.5f, -0.5f, 0.5f, 1.5f,
                                                        -1.5f, -0.5f, 0.5f, 1.5f, -1.5f, -0.5f, 0.5f, 1.5f};
  alignas(64) static constexpr float kAlongY[kGroup] = {
      -1.5f, -1.5f, -1.5f, -1.5f, -0.5f, -0.5f, -0.5f, -0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 1.5f, 1.5f, 1.5f, 1.5f};
  const VF sides = hn::Set(d, side), first = hn::Neg(half), last = hn::Set(d, images.rows_end - kBeforeEnd);
  alignas(64) float at_u[4 * kGroup], at_v[4 * kGroup], at_distance[4 * kGroup];
  uint64_t in = 0;
  for (size_t i = 0; i < kGroup; i += lanes) {
    const VF x = hn::Mul(hn::Load(d, kAlongX + i), sides), y = hn::Mul(hn::Load(d, kAlongY + i), sides);
    const auto layer = [&](float middle, const float slope[3]) {
      const VF flat = hn::Add(hn::Mul(x, hn::Set(d, slope[0])), hn::Mul(y, hn::Set(d, slope[1])));
      return hn::Add(flat, hn::Set(d, middle - 1.5f * side * slope[2]));
    };
    const VF u0 = layer(s.u, s.du), v0 = layer(s.v, s.dv), distance0 = layer(s.distance, s.ddistance);
    for (int z = 0; z < 4; ++z) {
      const auto at = static_cast<float>(z) * side;
      const size_t slot = static_cast<size_t>(z) * kGroup + i;
      const VF u = hn::Add(u0, hn::Set(d, at * s.du[2]));
      const VF unbound = hn::Add(v0, hn::Set(d, at * s.dv[2])), v = hn::Min(hn::Max(unbound, first), last);
      const VF distance = hn::Add(distance0, hn::Set(d, at * s.ddistance[2]));
      const VF row = hn::Floor(hn::Add(v, half)), column = hn::Floor(hn::Add(u, half));
      const MF behind = hn::And(hn::Eq(v, unbound), hn::Lt(distance, own.At(d, row, column)));
      in |= static_cast<uint64_t>(BitsOf(d, behind)) << slot;
      hn::Store(u, d, at_u + slot);
      hn::Store(v, d, at_v + slot);
      hn::Store(distance, d, at_distance + slot);
    }
  }
  GroupBits out{0, 0};
  for (size_t slot = 0; slot < 4 * kGroup; slot += lanes) {
    const uint32_t bits = static_cast<uint32_t>(in >> slot) & LaneBits(d);
    if (bits == 0) continue;
    const VF u = hn::Load(d, at_u + slot), v = hn::Load(d, at_v + slot),
             distance = hn::Load(d, at_distance + slot);
    const VF least = around.At(d, hn::Floor(v), hn::Floor(u));
    const uint32_t clear = BitsOf(d, hn::Lt(distance, least)) & bits;
    out.clear |= static_cast<uint64_t>(clear) << slot;
    if (clear == bits || images.pierce2 == 0.0f) continue;
    out.pierced |= static_cast<uint64_t>(BitsOf(d, PiercedByOwn(d, images, s, u, v)) & bits & ~clear) << slot;
  }
  return out;
}

HWY_INLINE GroupBits TestSmooth(const CellImages& images, const Slopes& s, float side) {
#ifdef ATLAS_IMAGE_WINDOWS
  if (s.window == 0) return TestSmoothBy<ImageWindow<0>>(images, s, side);
  if (s.window == 1) return TestSmoothBy<ImageWindow<1>>(images, s, side);
#endif
  return TestSmoothBy<WholeImage>(images, s, side);
}

}  // namespace HWY_NAMESPACE
}  // namespace atlas::mapping
HWY_AFTER_NAMESPACE();

#endif
