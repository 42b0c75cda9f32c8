#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/integrator/free_space/block_tests.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "mapping/integrator/free_space/cube-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atlas::mapping {
namespace HWY_NAMESPACE {

struct BoxVerdict {
  uint32_t mixed, full;
};

/// The smallest level whose windows cover `count` cells with two of 2^(level + shift).
HWY_INLINE VI LevelFor(DF d, VI count, int shift) {
  const DI di;
  const VI twice = hn::Sub(hn::Add(count, count), hn::Set(di, 1));
  const VI log2 =
      hn::Sub(hn::ShiftRight<23>(hn::BitCast(di, hn::ConvertTo(d, twice))), hn::Set(di, 127 + 1 + shift));
  return hn::Max(log2, hn::Zero(di));
}

struct Bounds {
  VF least_own, greatest;
  MF known;
};

/// Exact bounds over a footprint from four overlapping windows.
HWY_INLINE Bounds BoundsOf(DF d, const FreeSpaceTables& tables, const Footprint& f) {
  const DI di;
  const VI one = hn::Set(di, 1), zero = hn::Zero(di);
  const VI rows = hn::Add(hn::Sub(f.v1, f.v0), one), columns = hn::Add(hn::Sub(f.u1, f.u0), one);
  const VI level = hn::Max(LevelFor(d, rows, 0), LevelFor(d, columns, tables.box_shift));
  const MF known = hn::RebindMask(d, hn::Lt(level, hn::Set(di, FreeSpaceTables::kBoxLevels)));
  const VI k = hn::Min(level, hn::Set(di, FreeSpaceTables::kBoxLevels - 1));
  const VI tall = hn::Shl(one, k), wide = hn::Shl(tall, hn::Set(di, tables.box_shift));
  const VI turn = hn::Set(di, tables.image->columns);
  const auto wrap = [&](VI u) {
    u = hn::IfThenElse(hn::Lt(u, zero), hn::Add(u, turn), u);
    u = hn::IfThenElse(hn::Lt(u, turn), u, hn::Sub(u, turn));
    return hn::Min(hn::Max(u, zero), hn::Sub(turn, one));
  };
  const VI ua = wrap(f.u0), ub = wrap(hn::Max(f.u0, hn::Sub(hn::Add(f.u1, one), wide)));
  const VI pitch = hn::Set(di, static_cast<int>(tables.box_pitch));
  const VI base = hn::Mul(k, hn::Set(di, static_cast<int>(tables.box_stride)));
  const VI ra = hn::Add(base, hn::Mul(f.v0, pitch));
  const VI rb = hn::Add(base, hn::Mul(hn::Max(f.v0, hn::Sub(hn::Add(f.v1, one), tall)), pitch));
  const auto* table = reinterpret_cast<const int32_t*>(tables.box.data());
  const VI half = hn::Set(di, 0xffff);
  VI low = half, complement = half;
  for (const VI row : {ra, rb}) {
    for (const VI column : {ua, ub}) {
      const VI packed = hn::GatherIndex(di, table, hn::Add(row, column));
      low = hn::Min(low, hn::And(packed, half));
      complement = hn::Min(complement, hn::And(hn::ShiftRight<16>(packed), half));
    }
  }
  const VI high = hn::Sub(half, complement);
  const VF unit = hn::Set(d, tables.box_unit_m);
  return {hn::Mul(hn::ConvertTo(d, low), unit), hn::Mul(hn::ConvertTo(d, high), unit), known};
}

/// Cubes too near to the axis are not tested: mixed.
HWY_INLINE BoxVerdict VerdictOf(DF d, const FreeSpaceTables& tables, const ScanFrame& frame, const Cubes& m,
                                const Footprint& f, float half_side) {
  const float radius = half_side * kSqrt3 * frame.resolution_m;
  const MF near = hn::Lt(m.flat, hn::Set(d, kMinAxisDistanceRadii * radius));
  const Bounds bounds = BoundsOf(d, tables, f);
  // Of the voxels' middles the nearest, of the whole cube the farthest point.
  const VF nearest = hn::Sub(m.distance, hn::Mul(m.along, hn::Set(d, (half_side - 0.5f) / half_side)));
  const VF corner = hn::Sub(hn::Set(d, radius * radius), hn::Mul(m.along, m.along));
  const VF farthest = hn::Add(hn::Add(m.distance, m.along), hn::Div(corner, hn::Add(m.distance, m.distance)));
  const MF none = hn::And(bounds.known, hn::Ge(nearest, bounds.greatest));
  const MF gone = hn::AndNot(near, hn::Or(f.outside, none));
  const MF all = hn::And(bounds.known, hn::Lt(farthest, bounds.least_own));
  const MF full = hn::AndNot(hn::Or(near, hn::Or(gone, f.clipped)), all);
  const uint32_t full_bits = BitsOf(d, full), gone_bits = BitsOf(d, gone);
  return {LaneBits(d) & ~(full_bits | gone_bits), full_bits};
}

/// @param slopes  where not null, filled too where cubes are mixed.
CubeTests TestCubes(const FreeSpaceTables& tables, const ScanFrame& frame, const float* x, const float* y,
                    const float* z, float half_side, CubeSlopes* slopes) {
  const DF d;
  const size_t lanes = hn::Lanes(d);
  const float per_voxel = frame.resolution_m / static_cast<float>(tables.image->grid->min_pitch_rad);
  CubeTests out;
  for (size_t i = 0; i < kGroup; i += lanes) {
    const Cubes cubes =
        CubesAt(d, frame, hn::LoadU(d, x + i), hn::LoadU(d, y + i), hn::LoadU(d, z + i), half_side);
    const Footprint footprint = FootprintOf(d, *tables.image->grid, cubes);
    const BoxVerdict v = VerdictOf(d, tables, frame, cubes, footprint, half_side);
    const auto put = [&](uint32_t bits, uint32_t* to) { *to |= bits << i; };
    put(v.mixed, &out.mixed);
    put(v.full, &out.full);
    put(BitsOf(d, hn::Ge(cubes.distance, hn::Set(d, 2.0f * per_voxel))), &out.two_apart);
    put(BitsOf(d, hn::Ge(cubes.distance, hn::Set(d, 4.0f * per_voxel))), &out.four_apart);
    if (slopes == nullptr || v.mixed == 0) continue;
    put(BitsOf(d, StoreSlopes(d, frame, *tables.image->grid, cubes, footprint, half_side, i, slopes)),
        &out.smooth);
  }
  return out;
}

/// Cubes of 2^3 blocks first, then the blocks of those that are mixed.
void TestChunk(const FreeSpaceTables& tables, const ScanFrame& frame, const NodeKey& corner,
               BlockTests* out) {
  constexpr int kNodes = kChunkBlocks / 8;  // of level 4, in Morton order as their blocks are
  float x[kGroup], y[kGroup], z[kGroup];
  const auto place = [&](size_t lane, int block, float half_side) {
    const NodeKey b = BlockOffset(block);
    x[lane] = static_cast<float>(corner.x + kBlockSide * b.x) + half_side;
    y[lane] = static_cast<float>(corner.y + kBlockSide * b.y) + half_side;
    z[lane] = static_cast<float>(corner.z + kBlockSide * b.z) + half_side;
  };
  std::array<int, kNodes + 1> mixed;
  size_t mixed_count = 0;
  for (int first = 0; first < kNodes; first += 16) {
    for (int i = 0; i < 16; ++i) place(static_cast<size_t>(i), 8 * (first + i), 8.0f);
    const CubeTests tests = TestCubes(tables, frame, x, y, z, 8.0f, nullptr);
    for (int i = 0; i < 16; ++i) {
      const int node = first + i;
      if (tests.mixed >> i & 1) mixed[mixed_count++] = node;
      if (tests.full >> i & 1) {
        out->full.bits[static_cast<size_t>(node / 8)] |= uint64_t{0xff} << (8 * (node % 8));
      }
    }
  }
  mixed[mixed_count] = mixed[mixed_count == 0 ? 0 : mixed_count - 1];
  for (size_t pair = 0; pair < mixed_count; pair += 2) {
    for (size_t i = 0; i < 16; ++i) {
      place(i, 8 * mixed[pair + (i >> 3)] + static_cast<int>(i & 7), 4.0f);
    }
    const CubeTests tests = TestCubes(tables, frame, x, y, z, 4.0f, nullptr);
    for (size_t k = 0; k < 2; ++k) {
      const int node = mixed[pair + k];
      const auto put = [&](uint32_t bits, BlockMask* mask) {
        mask->bits[static_cast<size_t>(node / 8)] |= static_cast<uint64_t>(bits >> (8 * k) & 0xff)
                                                     << (8 * (node % 8));
      };
      put(tests.mixed, &out->mixed);
      put(tests.full, &out->full);
      put(tests.two_apart, &out->two_apart);
      put(tests.four_apart, &out->four_apart);
    }
  }
}

uint32_t SlopesOfBlocks(const FreeSpaceTables& tables, const ScanFrame& frame, const float* x, const float* y,
                        const float* z, CubeSlopes* out) {
  const DF d;
  const size_t lanes = hn::Lanes(d);
  constexpr float kHalf = 0.5f * kBlockSide;
  uint32_t smooth = 0;
  for (size_t i = 0; i < kGroup; i += lanes) {
    const Cubes cubes =
        CubesAt(d, frame, hn::LoadU(d, x + i), hn::LoadU(d, y + i), hn::LoadU(d, z + i), kHalf);
    const MF holds = StoreSlopes(d, frame, *tables.image->grid, cubes,
                                 FootprintOf(d, *tables.image->grid, cubes), kHalf, i, out);
    smooth |= BitsOf(d, holds) << i;
  }
  return smooth;
}

}  // namespace HWY_NAMESPACE
}  // namespace atlas::mapping
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace atlas::mapping {
namespace {
HWY_EXPORT(TestCubes);
HWY_EXPORT(TestChunk);
HWY_EXPORT(SlopesOfBlocks);
}  // namespace

CubeTests TestBoxes(const FreeSpaceTables& tables, const ScanFrame& frame, const float* x, const float* y,
                    const float* z, float half_side_voxels) {
  return HWY_DYNAMIC_DISPATCH(TestCubes)(tables, frame, x, y, z, half_side_voxels, nullptr);
}

void TestOctants(const FreeSpaceTables& tables, const ScanFrame& frame, const NodeKey corner[2],
                 OctantTests* out) {
  float x[16], y[16], z[16];
  for (size_t i = 0; i < 16; ++i) {
    const NodeKey& c = corner[i >> 3];
    x[i] = static_cast<float>(c.x + (i & 1 ? 6 : 2));
    y[i] = static_cast<float>(c.y + (i & 2 ? 6 : 2));
    z[i] = static_cast<float>(c.z + (i & 4 ? 6 : 2));
  }
  out->cubes = HWY_DYNAMIC_DISPATCH(TestCubes)(tables, frame, x, y, z, 2.0f, &out->slopes);
}

void TestBlocks(const FreeSpaceTables& tables, const ScanFrame& frame, const NodeKey& corner,
                BlockTests* out) {
  *out = BlockTests{};
  HWY_DYNAMIC_DISPATCH(TestChunk)(tables, frame, corner, out);
}

uint32_t FindBlockSlopes(const FreeSpaceTables& tables, const ScanFrame& frame, const NodeKey* corners,
                         size_t count, CubeSlopes* out) {
  float x[16], y[16], z[16];
  for (size_t i = 0; i < 16; ++i) {
    const NodeKey& c = corners[std::min(i, count - 1)];
    x[i] = static_cast<float>(c.x + kBlockSide / 2);
    y[i] = static_cast<float>(c.y + kBlockSide / 2);
    z[i] = static_cast<float>(c.z + kBlockSide / 2);
  }
  return HWY_DYNAMIC_DISPATCH(SlopesOfBlocks)(tables, frame, x, y, z, out);
}

}  // namespace atlas::mapping
#endif
