// Cells of one block against the beams, 16 at a time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/integrator/free_space/cell_tests.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "mapping/integrator/free_space/block_project-inl.h"
#include "mapping/integrator/free_space/smooth_cells-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atlas::mapping {
namespace HWY_NAMESPACE {

constexpr float kPierceCone =
    2.0f;  ///< voxels between beams: wider, and the few voxels that they pierce do not count
constexpr float kWindowShare = 0.75f;  ///< of a cell's width that the veto window must cover

HWY_INLINE CellImages ImagesFor(const FreeSpaceTables& tables, const ScanFrame& frame, float distance,
                                int scale) {
  const size_t s = scale == 1 ? 0 : scale == 2 ? 1 : 2;
  size_t level = 1;
  if (scale == 1) {
    const float nearest = std::max(distance - 0.5f * kBlockRadius * frame.resolution_m, 0.3f);
    const float width =
        frame.resolution_m / (static_cast<float>(tables.image->grid->min_pitch_rad) * nearest);
    while (level + 1 < FreeSpaceTables::kLevels &&
           static_cast<float>(1 << level) < kWindowShare * width + 1.0f)
      ++level;
  }
  CellImages images;
  images.tables = &tables;
  images.own = tables.own[s].data();
  images.around = level == 1 ? tables.surround[s].data() : tables.window[level].data();
  images.pitch = static_cast<float>(tables.pitch);
  images.columns = tables.image->columns;
  images.row_offset = static_cast<float>(tables.window_rows[level] / 2 - 1);
  images.columns_before = tables.window_columns[level] / 2 - 1;
  images.rows_end = static_cast<float>(tables.image->rows) - 0.5f;
  const float radius = tables.pierce_voxels * static_cast<float>(scale) * frame.resolution_m;
  const float cone = distance * static_cast<float>(tables.image->grid->min_pitch_rad);
  images.pierce2 = cone < kPierceCone * frame.resolution_m ? radius * radius : 0.0f;
  return images;
}

/// Up to four groups of cells in grid coordinates, and which of them lie in front of their own beams.
struct Projected {
  alignas(64) float u[4 * kGroup], v[4 * kGroup], distance[4 * kGroup];
};

/// Bits of Lanes(d) cells whose nearest beam returned behind them.
HWY_INLINE uint32_t TestOwn(DF d, const CellImages& images, const GridPoint& p) {
  const DI di;
  const VF half = hn::Set(d, 0.5f);
  const MF in = hn::And(hn::Ge(p.v, hn::Neg(half)), hn::Lt(p.v, hn::Set(d, images.rows_end)));
  const VF row = hn::Floor(hn::Add(hn::IfThenElseZero(in, p.v), half));
  const VF column = hn::Floor(hn::Add(p.u, half));
  // Exact: tables have fewer than 2^24 cells.
  const VI index = hn::ConvertTo(di, hn::Add(hn::Mul(row, hn::Set(d, images.pitch)), column));
  const VF own = hn::GatherIndex(d, images.own, index);
  return BitsOf(d, hn::And(in, hn::Lt(p.distance, own)));
}

struct Verdict {
  uint32_t clear, pierced;
};

/// Of Lanes(d) cells that passed TestOwn: those without a beam in front around them, and of the others those
/// that their nearest beam passes through.
HWY_INLINE Verdict TestAround(DF d, const CellImages& images, const GridPoint& p, uint32_t in) {
  const DI di;
  const FreeSpaceTables& tables = *images.tables;
  const VF half = hn::Set(d, 0.5f), one = hn::Set(d, 1.0f);
  const VF v = hn::Max(p.v, hn::Neg(half));
  const VF upper = hn::Add(hn::Floor(hn::Add(v, one)), hn::Set(d, images.row_offset));
  VF left = hn::Sub(hn::Floor(p.u), hn::Set(d, static_cast<float>(images.columns_before)));
  const VF columns = hn::Set(d, static_cast<float>(images.columns));
  left = hn::IfThenElse(hn::Lt(left, hn::Zero(d)), hn::Add(left, columns), left);
  const VF last = hn::Set(d, images.rows_end + images.row_offset + 0.5f);
  const VI window = hn::ConvertTo(di, hn::Add(hn::Mul(hn::Min(upper, last), hn::Set(d, images.pitch)), left));
  const VF around = hn::GatherIndex(d, images.around, window);
  const uint32_t clear = BitsOf(d, hn::Lt(p.distance, around)) & in;
  if (clear == in || images.pierce2 == 0.0f) return {clear, 0};

  const VF row = hn::Min(hn::Floor(hn::Add(v, half)), hn::Set(d, images.rows_end - 0.5f));
  const VF column = hn::Floor(hn::Add(p.u, half));
  const VF wrapped = hn::IfThenElse(hn::Lt(column, columns), column, hn::Sub(column, columns));
  const VI row_index = hn::ConvertTo(di, row);
  const VI cell = hn::ConvertTo(di, hn::Add(hn::Mul(row, columns), wrapped));
  const Offsets ray = UnpackOffsets(d, hn::GatherIndex(di, tables.image->offset.data(), cell));
  const VF row_pitch = hn::GatherIndex(d, tables.image->grid->row_pitch_rad.data(), row_index);
  const VF cosine = hn::GatherIndex(d, tables.image->grid->cos_elevation.data(), row_index);
  const VF pitch = hn::Mul(hn::Set(d, static_cast<float>(tables.image->grid->column_pitch_rad)), cosine);
  const VF eu = hn::Mul(hn::Mul(hn::Sub(hn::Sub(p.u, column), ray.u), pitch), p.distance);
  const VF ev = hn::Mul(hn::Mul(hn::Sub(hn::Sub(p.v, row), ray.v), row_pitch), p.distance);
  const MF through = hn::Lt(hn::Add(hn::Mul(eu, eu), hn::Mul(ev, ev)), hn::Set(d, images.pierce2));
  return {clear, BitsOf(d, through) & in & ~clear};
}

/// `groups` (at most 4) groups of 16 cells, from `first` by `step`. Projects them all before it looks around,
/// so that their latencies overlap.
template <typename Projector>
HWY_INLINE GroupBits TestGroups(const CellImages& images, const Lattice& lattice, const Projector& projector,
                                const float first[3], const float step[3], int groups) {
  const DF d;
  const size_t lanes = hn::Lanes(d);
  Projected at;
  uint64_t in = 0;
  for (int j = 0; j < groups; ++j) {
    float base[3];
    for (int c = 0; c < 3; ++c) base[c] = first[c] + static_cast<float>(j) * step[c];
    for (size_t i = 0; i < kGroup; i += lanes) {
      const size_t slot = static_cast<size_t>(j) * kGroup + i;
      const VF x = hn::Add(hn::Set(d, base[0]), hn::Load(d, lattice.lane[0] + i));
      const VF y = hn::Add(hn::Set(d, base[1]), hn::Load(d, lattice.lane[1] + i));
      const VF z = hn::Add(hn::Set(d, base[2]), hn::Load(d, lattice.lane[2] + i));
      const GridPoint p = projector.Project(d, x, y, z);
      hn::Store(p.u, d, at.u + slot);
      hn::Store(p.v, d, at.v + slot);
      hn::Store(p.distance, d, at.distance + slot);
      in |= static_cast<uint64_t>(TestOwn(d, images, p)) << slot;
    }
  }
  GroupBits out{0, 0};
  for (size_t slot = 0; slot < static_cast<size_t>(groups) * kGroup; slot += lanes) {
    const uint32_t bits = static_cast<uint32_t>(in >> slot) & LaneBits(d);
    if (bits == 0) continue;
    const GridPoint p{hn::Load(d, at.u + slot), hn::Load(d, at.v + slot), hn::Load(d, at.distance + slot)};
    const Verdict verdict = TestAround(d, images, p, bits);
    out.clear |= static_cast<uint64_t>(verdict.clear) << slot;
    out.pierced |= static_cast<uint64_t>(verdict.pierced) << slot;
  }
  return out;
}

/// Spreads the 4^3 voxels of an octant, x fastest, over the block's layers.
HWY_INLINE void SetOctant(int octant, uint64_t voxels, VoxelBits* free) {
  const int shift = 4 * (octant & 1) + 32 * (octant >> 1 & 1);
  for (int z = 0; z < 4; ++z) {
    uint64_t layer = voxels >> (16 * z) & 0xffff;  // bit x + 4 y to bit x + 8 y
    layer = (layer | layer << 8) & 0x00ff00ff;
    layer = (layer | layer << 4) & 0x0f0f0f0f;
    free->layer[static_cast<size_t>(4 * (octant >> 2) + z)] |= layer << shift;
  }
}

template <typename Projector>
HWY_INLINE void TestLattice(const CellImages& images, const Lattice& lattice, const float step_x[3],
                            const Projector& projector, uint32_t octants, VoxelBits* free) {
  for (; octants != 0; octants &= octants - 1) {
    const int octant = __builtin_ctz(octants);
    const auto x = static_cast<float>(4 * (octant & 1)), y = static_cast<float>(2 * (octant >> 1 & 1)),
               z = static_cast<float>(4 * (octant >> 2));
    float first[3];
    for (int c = 0; c < 3; ++c) {
      first[c] = lattice.first[c] + x * step_x[c] + y * lattice.step_y[c] + z * lattice.step_z[c];
    }
    const GroupBits bits = TestGroups(images, lattice, projector, first, lattice.step_z, 4);
    SetOctant(octant, bits.clear | bits.pierced, free);
  }
}

void TestBlockVoxels(const FreeSpaceTables& tables, const ScanFrame& frame, const NodeKey& corner,
                     const OctantTests& tests, int first, uint32_t octants, VoxelBits* free) {
  const Place place = PlaceOf(frame, corner, kBlockSide);
  const CellImages images = ImagesFor(tables, frame, place.distance, 1);
  uint32_t smooth = octants & tests.cubes.smooth >> first;
  if (images.columns_before > kColumnsSpare) smooth = 0;
  for (uint32_t bits = smooth; bits != 0; bits &= bits - 1) {
    const int octant = __builtin_ctz(bits);
    const GroupBits cells =
        TestSmooth(images, SlopesOf(tests.slopes, static_cast<size_t>(first + octant)), 1.0f);
    SetOctant(octant, cells.clear | cells.pierced, free);
  }
  octants &= ~smooth;
  if (octants == 0) return;
  const Lattice lattice = LatticeOf(frame, frame.lanes_1_octant, corner, 1, place.turn);
  float step_x[3];
  Turn(place.turn, frame.axis[0], step_x);
  if (place.near) {
    TestLattice(images, lattice, step_x, NearProjector{*tables.image->grid}, octants, free);
  } else {
    FarProjector projector;
    SetProjector(*tables.image->grid, place, kBlockRadius * frame.resolution_m, &projector);
    TestLattice(images, lattice, step_x, projector, octants, free);
  }
}

uint64_t TestBlockCells(const FreeSpaceTables& tables, const ScanFrame& frame, const NodeKey& corner,
                        const CubeSlopes* slopes, size_t lane) {
  const Place place = PlaceOf(frame, corner, kBlockSide);
  const CellImages images = ImagesFor(tables, frame, place.distance, 2);
  if (slopes != nullptr) return TestSmooth(images, SlopesOf(*slopes, lane), 2.0f).clear;
  const float still[2] = {1.0f, 0.0f};
  const Lattice lattice = LatticeOf(frame, frame.lanes_2, corner, 2, still);
  return TestGroups(images, lattice, NearProjector{*tables.image->grid}, lattice.first, lattice.step_z, 4)
      .clear;
}

uint32_t TestBlockPair(const FreeSpaceTables& tables, const ScanFrame& frame, const NodeKey corner[2]) {
  const float still[2] = {1.0f, 0.0f};
  Lattice lattice = LatticeOf(frame, frame.lanes_4, corner[0], 4, still);
  const float apart[3] = {static_cast<float>(corner[1].x - corner[0].x),
                          static_cast<float>(corner[1].y - corner[0].y),
                          static_cast<float>(corner[1].z - corner[0].z)};
  for (int c = 0; c < 3; ++c) {
    const float across =
        apart[0] * frame.axis[0][c] + apart[1] * frame.axis[1][c] + apart[2] * frame.axis[2][c];
    for (size_t i = 8; i < kGroup; ++i) lattice.lane[c][i] += across;
  }
  const CellImages images = ImagesFor(tables, frame, PlaceOf(frame, corner[0], kBlockSide).distance, 4);
  const GroupBits bits =
      TestGroups(images, lattice, NearProjector{*tables.image->grid}, lattice.first, lattice.step_z, 1);
  return static_cast<uint32_t>(bits.clear);
}

}  // namespace HWY_NAMESPACE
}  // namespace atlas::mapping
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace atlas::mapping {
namespace {
HWY_EXPORT(TestBlockVoxels);
HWY_EXPORT(TestBlockCells);
HWY_EXPORT(TestBlockPair);
}  // namespace

void ScanFrame::SetLanes() {
  const auto set = [this](int scale, int along_x, int along_y, Lanes* lanes) {
    for (int i = 0; i < 16; ++i) {
      const int cell[3] = {i % along_x, i / along_x % along_y, scale == 4 ? i / (along_x * along_y) % 2 : 0};
      for (int c = 0; c < 3; ++c) {
        float sum = 0.0f;
        for (int a = 0; a < 3; ++a) sum += static_cast<float>(scale * cell[a]) * axis[a][c];
        lanes->offset[c][i] = sum;
      }
    }
  };
  set(1, 8, 2, &lanes_1);
  set(1, 4, 4, &lanes_1_octant);
  set(2, 4, 4, &lanes_2);
  set(4, 2, 2, &lanes_4);
}

void TestVoxels(const FreeSpaceTables& tables, const ScanFrame& frame, const NodeKey& corner,
                const OctantTests& tests, int first, uint32_t octants, VoxelBits* free) {
  HWY_DYNAMIC_DISPATCH(TestBlockVoxels)(tables, frame, corner, tests, first, octants, free);
}

uint64_t TestCells(const FreeSpaceTables& tables, const ScanFrame& frame, const NodeKey& corner,
                   const CubeSlopes* slopes, size_t lane) {
  return HWY_DYNAMIC_DISPATCH(TestBlockCells)(tables, frame, corner, slopes, lane);
}

uint32_t TestWideCells(const FreeSpaceTables& tables, const ScanFrame& frame, const NodeKey corner[2]) {
  return HWY_DYNAMIC_DISPATCH(TestBlockPair)(tables, frame, corner);
}

}  // namespace atlas::mapping
#endif
