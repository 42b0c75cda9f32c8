#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/integrator/block_tests.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "mapping/integrator/fill_kernels.h"
#include "mapping/integrator/project-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atlas::mapping {
namespace HWY_NAMESPACE {

constexpr float kSqrt3 = 1.7320508f;
constexpr float kNear = 2.5f;        ///< closer than this many radii to the axis: not tested, taken as mixed
constexpr float kArcExcess = 1.05f;  ///< asin(x) / x below x = 1 / kNear

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

/// Cells that a box can touch: rows [v0, v1], columns [u0, u1] with u0 possibly a turn off.
struct Footprint {
  VI v0, v1, u0, u1;
  MF outside, clipped;
};

HWY_INLINE Footprint FootprintOf(DF d, const BeamGrid& grid, VF x, VF y, VF z, VF distance, float radius) {
  const DI di;
  const VF one = hn::Set(d, 1.0f);
  const VF flat = hn::Sqrt(hn::Add(hn::Mul(x, x), hn::Mul(y, y)));
  const VF safe_flat = hn::Max(flat, hn::Set(d, 1e-6f));
  const VF inverse = hn::Div(one, hn::Max(distance, hn::Set(d, 1e-6f)));
  // Sines of the elevation plus and minus the angular radius.
  const VF sa = hn::Min(hn::Mul(hn::Set(d, radius), inverse), one);
  const VF ca = hn::Sqrt(hn::Sub(one, hn::Mul(sa, sa)));
  const VF se = hn::Mul(z, inverse), ce = hn::Mul(flat, inverse);
  const VF a = hn::Mul(se, ca), b = hn::Mul(ce, sa);
  const VF top = RowOf(d, grid, hn::Add(a, b)), bottom = RowOf(d, grid, hn::Sub(a, b));
  const VF last = hn::Set(d, static_cast<float>(grid.rows - 1));
  const VF half = hn::Set(d, 0.5f);
  Footprint f;
  f.outside = hn::Or(hn::Lt(bottom, hn::Neg(half)), hn::Gt(top, hn::Add(last, half)));
  f.clipped = hn::Or(hn::Lt(top, hn::Zero(d)), hn::Gt(bottom, last));
  f.v0 = FloorPositive(di, hn::Min(hn::Max(top, hn::Zero(d)), last));
  f.v1 = hn::Min(FloorPositive(di, hn::Add(hn::Max(bottom, hn::Zero(d)), one)), hn::Set(di, grid.rows - 1));
  const VF u = ColumnOf(d, grid, x, y);
  const VF reach = hn::Mul(hn::Div(hn::Set(d, radius), safe_flat),
                           hn::Set(d, kArcExcess / static_cast<float>(grid.column_pitch_rad)));
  const VF turn = hn::Set(d, static_cast<float>(grid.columns));
  f.u0 = hn::Sub(FloorPositive(di, hn::Add(hn::Max(hn::Sub(u, reach), hn::Neg(turn)), turn)),
                 hn::Set(di, grid.columns));
  f.u1 = FloorPositive(di, hn::Add(hn::Min(hn::Add(u, reach), hn::Add(turn, turn)), one));
  return f;
}

struct Bounds {
  VF least_own, greatest;
  MF known;
};

/// Exact bounds over a footprint from four overlapping windows.
HWY_INLINE Bounds BoundsOf(DF d, const ScanImage& image, const Footprint& f) {
  const DI di;
  const VI one = hn::Set(di, 1), zero = hn::Zero(di);
  const VI rows = hn::Add(hn::Sub(f.v1, f.v0), one), columns = hn::Add(hn::Sub(f.u1, f.u0), one);
  const VI level = hn::Max(LevelFor(d, rows, 0), LevelFor(d, columns, image.box_shift));
  const MF known = hn::RebindMask(d, hn::Lt(level, hn::Set(di, ScanImage::kBoxLevels)));
  const VI k = hn::Min(level, hn::Set(di, ScanImage::kBoxLevels - 1));
  const VI tall = hn::Shl(one, k), wide = hn::Shl(tall, hn::Set(di, image.box_shift));
  const VI turn = hn::Set(di, image.columns);
  const auto wrap = [&](VI u) {
    u = hn::IfThenElse(hn::Lt(u, zero), hn::Add(u, turn), u);
    u = hn::IfThenElse(hn::Lt(u, turn), u, hn::Sub(u, turn));
    return hn::Min(hn::Max(u, zero), hn::Sub(turn, one));
  };
  const VI ua = wrap(f.u0), ub = wrap(hn::Max(f.u0, hn::Sub(hn::Add(f.u1, one), wide)));
  const VI pitch = hn::Set(di, static_cast<int>(image.box_pitch));
  const VI base = hn::Mul(k, hn::Set(di, static_cast<int>(image.box_stride)));
  const VI ra = hn::Add(base, hn::Mul(f.v0, pitch));
  const VI rb = hn::Add(base, hn::Mul(hn::Max(f.v0, hn::Sub(hn::Add(f.v1, one), tall)), pitch));
  const auto* table = reinterpret_cast<const int32_t*>(image.box.data());
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
  const VF unit = hn::Set(d, image.box_unit_m);
  return {hn::Mul(hn::ConvertTo(d, low), unit), hn::Mul(hn::ConvertTo(d, high), unit), known};
}

HWY_INLINE BoxVerdict TestVector(DF d, const ScanImage& image, const ScanFrame& frame, VF wx, VF wy, VF wz,
                                 float half_side) {
  const VF dx = hn::Sub(wx, hn::Set(d, frame.sensor[0])), dy = hn::Sub(wy, hn::Set(d, frame.sensor[1])),
           dz = hn::Sub(wz, hn::Set(d, frame.sensor[2]));
  const auto component = [&](int c) {
    return hn::Add(
        hn::Add(hn::Mul(dx, hn::Set(d, frame.axis[0][c])), hn::Mul(dy, hn::Set(d, frame.axis[1][c]))),
        hn::Mul(dz, hn::Set(d, frame.axis[2][c])));
  };
  const VF x = component(0), y = component(1), z = component(2);
  const float radius = half_side * kSqrt3 * frame.resolution_m;
  const float centres = (half_side - 0.5f) * kSqrt3 * frame.resolution_m;  // radius of the voxels' centres
  const VF flat2 = hn::Add(hn::Mul(x, x), hn::Mul(y, y));
  const VF distance = hn::Sqrt(hn::Add(flat2, hn::Mul(z, z)));
  const MF near = hn::Lt(flat2, hn::Set(d, kNear * kNear * radius * radius));
  const Footprint f = FootprintOf(d, *image.grid, x, y, z, distance, radius);
  const Bounds bounds = BoundsOf(d, image, f);
  const MF none = hn::And(bounds.known, hn::Ge(hn::Sub(distance, hn::Set(d, centres)), bounds.greatest));
  const MF gone = hn::AndNot(near, hn::Or(f.outside, none));
  const MF all = hn::And(bounds.known, hn::Lt(hn::Add(distance, hn::Set(d, radius)), bounds.least_own));
  const MF full = hn::AndNot(hn::Or(near, hn::Or(gone, f.clipped)), all);
  const uint32_t full_bits = BitsOf(d, full), gone_bits = BitsOf(d, gone);
  return {~(full_bits | gone_bits), full_bits};
}

void TestBoxGroup(const ScanImage& image, const ScanFrame& frame, const float* x, const float* y,
                  const float* z, float half_side, uint32_t* mixed, uint32_t* full) {
  const DF d;
  const size_t lanes = hn::Lanes(d);
  const uint32_t lane_bits = static_cast<uint32_t>((uint64_t{1} << lanes) - 1);
  uint32_t m = 0, f = 0;
  for (size_t i = 0; i < kGroup; i += lanes) {
    const BoxVerdict v =
        TestVector(d, image, frame, hn::LoadU(d, x + i), hn::LoadU(d, y + i), hn::LoadU(d, z + i), half_side);
    m |= (v.mixed & lane_bits) << i;
    f |= (v.full & lane_bits) << i;
  }
  *mixed = m;
  *full = f;
}

void TestChunk(const ScanImage& image, const ScanFrame& frame, const NodeKey& corner, BlockMask* mixed,
               BlockMask* full) {
  float x[kGroup], y[kGroup], z[kGroup];
  for (int group = 0; group < kChunkBlocks / 16; ++group) {
    for (int i = 0; i < 16; ++i) {
      const NodeKey block = BlockOffset(16 * group + i);
      const auto at = static_cast<size_t>(i);
      x[at] = static_cast<float>(corner.x + 8 * block.x + 4);
      y[at] = static_cast<float>(corner.y + 8 * block.y + 4);
      z[at] = static_cast<float>(corner.z + 8 * block.z + 4);
    }
    uint32_t m, f;
    TestBoxGroup(image, frame, x, y, z, 4.0f, &m, &f);
    const auto word = static_cast<size_t>(group / 4);
    mixed->bits[word] |= static_cast<uint64_t>(m) << (16 * (group % 4));
    full->bits[word] |= static_cast<uint64_t>(f) << (16 * (group % 4));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace atlas::mapping
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace atlas::mapping {
namespace {
HWY_EXPORT(TestBoxGroup);
HWY_EXPORT(TestChunk);
}  // namespace

void TestBoxes(const ScanImage& image, const ScanFrame& frame, const float* x, const float* y, const float* z,
               float half_side_voxels, uint32_t* mixed, uint32_t* full) {
  HWY_DYNAMIC_DISPATCH(TestBoxGroup)(image, frame, x, y, z, half_side_voxels, mixed, full);
}

void TestBlocks(const ScanImage& image, const ScanFrame& frame, const NodeKey& corner, BlockMask* mixed,
                BlockMask* full) {
  *mixed = BlockMask{};
  *full = BlockMask{};
  HWY_DYNAMIC_DISPATCH(TestChunk)(image, frame, corner, mixed, full);
}

}  // namespace atlas::mapping
#endif
