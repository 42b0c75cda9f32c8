// Cells of one block against the beams, 16 at a time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/integrator/cell_tests.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "mapping/integrator/block_project-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atlas::mapping {
namespace HWY_NAMESPACE {

constexpr float kPierceRadius = 0.71f;  ///< cells: a beam that passes this near to the middle pierces it
constexpr float kWindowShare = 0.75f;   ///< of a cell's width that the veto window must cover

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
  out->voxels.fill(0);
  bool pierced = false;
  WithProjector(image, frame, corner, scale,
                [&](const Lattice& lattice, const auto& projector, float distance) HWY_ATTR {
                  const CellImages images = ImagesFor(image, frame, distance, scale);
                  pierced = TestLattice(images, lattice, projector, out->voxels.data(), scale == 1);
                });
  return pierced;
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
