// Vectors of directions to grid coordinates, for each SIMD target. Included again for each by
// hwy/foreach_target.h. Only operations that IEEE 754 rounds exactly, so that all targets agree to the bit.
#if defined(ATLAS_MAPPING_INTEGRATOR_PROJECT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATLAS_MAPPING_INTEGRATOR_PROJECT_INL_H_
#undef ATLAS_MAPPING_INTEGRATOR_PROJECT_INL_H_
#else
#define ATLAS_MAPPING_INTEGRATOR_PROJECT_INL_H_
#endif

#include <hwy/highway.h>

#include "mapping/integrator/projection/range_image.h"

HWY_BEFORE_NAMESPACE();
namespace atlas::mapping {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Logical groups have 16 lanes on every target, worked Lanes(d) at a time.
constexpr size_t kGroup = 16;
using DF = hn::CappedTag<float, kGroup>;
using DI = hn::RebindToSigned<DF>;
using VF = hn::Vec<DF>;
using VI = hn::Vec<DI>;
using MF = hn::Mask<DF>;

/// A bit each of Lanes(d) lanes.
HWY_INLINE uint32_t LaneBits(DF d) {
  return static_cast<uint32_t>((uint64_t{1} << hn::Lanes(d)) - 1);
}
HWY_INLINE uint32_t BitsOf(DF d, MF mask) {
  uint64_t bits = 0;  // little-endian, as all targets here are
  hn::StoreMaskBits(d, mask, reinterpret_cast<uint8_t*>(&bits));
  return static_cast<uint32_t>(bits) & LaneBits(d);
}

/// And back, for lanes of any kind; bits beyond them do not count.
template <typename D>
HWY_INLINE hn::Mask<D> MaskOf(D d, uint64_t bits) {
  return hn::LoadMaskBits(d, reinterpret_cast<const uint8_t*>(&bits));
}

/// Calls visit(at of lane 0, lanes) for sets of lanes, a bit each, whose `at` grows by one from lane to lane,
/// until all of `wanted` had their turn.
template <typename Visit>
HWY_INLINE void ForRuns(DF d, VI at, MF wanted, const Visit& visit) {
  const DI di;
  alignas(64) int32_t first[kGroup];
  const VI from = hn::Sub(at, hn::Iota(di, 0));
  hn::Store(from, di, first);
  for (uint32_t left = BitsOf(d, wanted); left != 0;) {
    const int32_t next = first[__builtin_ctz(left)];
    const uint32_t run = BitsOf(d, hn::RebindMask(d, hn::Eq(from, hn::Set(di, next)))) & left;
    left &= ~run;
    visit(next, run);
  }
}

/// RangeImage::offset and back.
struct Offsets {
  VF u, v;
};
HWY_INLINE VI PackOffsets(DF d, VF u, VF v) {
  const DI di;
  const VF scale = hn::Set(d, RangeImage::kPerCell), half = hn::Set(d, 0.5f);
  const VI low = hn::ConvertTo(di, hn::Floor(hn::Add(hn::Mul(u, scale), half)));
  const VI high = hn::ConvertTo(di, hn::Floor(hn::Add(hn::Mul(v, scale), half)));
  return hn::Or(hn::And(low, hn::Set(di, 0xffff)), hn::ShiftLeft<16>(high));
}
HWY_INLINE Offsets UnpackOffsets(DF d, VI packed) {
  const VF scale = hn::Set(d, 1.0f / RangeImage::kPerCell);
  return {hn::Mul(hn::ConvertTo(d, hn::ShiftRight<16>(hn::ShiftLeft<16>(packed))), scale),
          hn::Mul(hn::ConvertTo(d, hn::ShiftRight<16>(packed)), scale)};
}

/// Calls visit(first) for vectors of `lanes` columns that cover the filled ones; the last of a run may
/// overlap the one before.
template <typename Visit>
HWY_INLINE void ForColumns(const GridColumns& image, size_t lanes, const Visit& visit) {
  for (const GridColumns::Run& run : image.runs) {
    for (size_t c = run.first; c < run.last; c += lanes) visit(std::min(c, run.last - lanes));
  }
}

/// Largest integer not above x. @pre x >= 0.
HWY_INLINE VI FloorPositive(DI di, VF x) {
  return hn::ConvertTo(di, x);
}

/// atan(t) for |t| <= 1, error below 2e-6 rad (least maximum error fit of six odd terms).
HWY_INLINE VF AtanOfUnit(DF d, VF t) {
  const VF s = hn::Mul(t, t);
  VF p = hn::Set(d, -0.0117191346f);
  p = hn::Add(hn::Mul(p, s), hn::Set(d, 0.0526473495f));
  p = hn::Add(hn::Mul(p, s), hn::Set(d, -0.116426482f));
  p = hn::Add(hn::Mul(p, s), hn::Set(d, 0.193540377f));
  p = hn::Add(hn::Mul(p, s), hn::Set(d, -0.332622828f));
  p = hn::Add(hn::Mul(p, s), hn::Set(d, 0.999977219f));
  return hn::Mul(p, t);
}

/// atan(t) for |t| <= 0.45, error below 3e-7 rad.
HWY_INLINE VF AtanOfSmall(DF d, VF t) {
  const VF s = hn::Mul(t, t);
  VF p = hn::Set(d, -0.102827862f);
  p = hn::Add(hn::Mul(p, s), hn::Set(d, 0.194425039f));
  p = hn::Add(hn::Mul(p, s), hn::Set(d, -0.33303453f));
  p = hn::Add(hn::Mul(p, s), hn::Set(d, 0.999995622f));
  return hn::Mul(p, t);
}

HWY_INLINE VF Azimuth(DF d, VF x, VF y) {
  const VF ax = hn::Abs(x), ay = hn::Abs(y);
  const VF ratio = hn::Div(hn::Min(ax, ay), hn::Max(hn::Max(ax, ay), hn::Set(d, 1e-9f)));
  VF a = AtanOfUnit(d, ratio);
  a = hn::IfThenElse(hn::Gt(ay, ax), hn::Sub(hn::Set(d, 1.57079633f), a), a);
  a = hn::IfThenElse(hn::Lt(x, hn::Zero(d)), hn::Sub(hn::Set(d, 3.14159265f), a), a);
  return hn::CopySign(a, y);
}

/// u wrapped into [0, columns), from at most a turn outside.
HWY_INLINE VF WrapColumn(DF d, VF u, float columns) {
  const VF w = hn::Set(d, columns);
  u = hn::IfThenElse(hn::Lt(u, hn::Zero(d)), hn::Add(u, w), u);
  return hn::IfThenElse(hn::Ge(u, w), hn::Sub(u, w), u);
}

HWY_INLINE VF ColumnOf(DF d, const BeamGrid& grid, VF x, VF y) {
  const VF u = hn::Mul(hn::Sub(Azimuth(d, x, y), hn::Set(d, static_cast<float>(grid.phase_rad))),
                       hn::Set(d, static_cast<float>(1.0 / grid.column_pitch_rad)));
  return WrapColumn(d, u, static_cast<float>(grid.columns));
}

/// Row coordinate of directions with this sine of elevation.
HWY_INLINE VF RowOf(DF d, const BeamGrid& grid, VF sine) {
  const DI di;
  if (grid.polynomial) {
    const VF s = hn::Min(hn::Max(sine, hn::Set(d, grid.sin_min)), hn::Set(d, grid.sin_max));
    const VF square = hn::Mul(s, s);
    VF p = hn::Set(d, grid.row_terms.back());
    for (size_t i = grid.row_terms.size() - 1; i-- > 0;) {
      p = hn::Add(hn::Mul(p, square), hn::Set(d, grid.row_terms[i]));
    }
    return hn::Add(hn::Mul(p, s), hn::Set(d, grid.row_of_level));
  }
  const VF top = hn::Set(d, static_cast<float>(BeamGrid::kTableIntervals) - 0.001f);
  VF x = hn::Mul(hn::Sub(sine, hn::Set(d, grid.sin_min)), hn::Set(d, grid.intervals_per_sin));
  x = hn::Min(hn::Max(x, hn::Zero(d)), top);
  const VI i = FloorPositive(di, x);
  const VF a = hn::GatherIndex(d, grid.row_of_sin.data(), i);
  const VF b = hn::GatherIndex(d, grid.row_of_sin.data() + 1, i);
  return hn::Add(a, hn::Mul(hn::Sub(x, hn::ConvertTo(d, i)), hn::Sub(b, a)));
}

}  // namespace HWY_NAMESPACE
}  // namespace atlas::mapping
HWY_AFTER_NAMESPACE();

#endif
