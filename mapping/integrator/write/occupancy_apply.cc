#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/integrator/write/occupancy_apply.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "mapping/integrator/write/occupancy_apply.h"

HWY_BEFORE_NAMESPACE();
namespace atlas::mapping {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D8 = hn::CappedTag<int8_t, 64>;
using V8 = hn::Vec<D8>;
using M8 = hn::Mask<D8>;

HWY_INLINE M8 MaskOf(D8 d, uint64_t bits) {
  return hn::LoadMaskBits(d, reinterpret_cast<const uint8_t*>(&bits));
}

HWY_INLINE uint64_t BitsOf(D8 d, M8 mask) {
  uint64_t bits = 0;
  hn::StoreMaskBits(d, mask, reinterpret_cast<uint8_t*>(&bits));
  return bits;
}

/// The value after a miss; 0 leaves it. Misses are whole steps, so that places stay.
HWY_INLINE V8 Lower(D8 d, V8 value, V8 miss) {
  const V8 zero = hn::Zero(d);
  const V8 sum = hn::Max(hn::SaturatedAdd(value, miss), hn::Set(d, OccupancyField::kMin));
  const M8 cancelled = hn::AndNot(hn::Eq(miss, zero), hn::Eq(sum, zero));
  return hn::IfThenElse(cancelled, hn::Set(d, 1), sum);
}

/// The value after an update by whole steps and, of what is positive, a place. Places go a step towards those
/// of returns; others only in voxels that have none.
HWY_INLINE V8 Update(D8 d, V8 value, V8 delta, V8 hit) {
  const V8 zero = hn::Zero(d), one = hn::Set(d, 1), bits = hn::Set(d, OccupancyField::kPlaces - 1);
  const M8 placed = hn::Gt(value, zero), places = hn::Gt(delta, zero), returned = hn::Not(hn::Lt(delta, hit));
  const V8 old_place = hn::And(value, bits), update = hn::IfThenElseZero(places, hn::And(delta, bits));
  const V8 towards = hn::Min(hn::Max(hn::Sub(update, old_place), hn::Neg(one)), one);
  const V8 kept = hn::Add(old_place, hn::IfThenElseZero(returned, towards));
  const V8 place = hn::IfThenElse(placed, kept, update);
  const V8 base = hn::IfThenElse(placed, hn::AndNot(bits, value), value);
  V8 sum = hn::SaturatedAdd(base, hn::IfThenElse(places, hn::AndNot(bits, delta), delta));
  sum = hn::Min(hn::Max(sum, hn::Set(d, OccupancyField::kMin)), hn::Set(d, OccupancyField::kMax));
  sum = hn::IfThenElse(hn::Gt(sum, zero), hn::Or(hn::AndNot(bits, sum), place), sum);
  sum = hn::IfThenElse(hn::Eq(sum, zero), one, sum);
  return hn::IfThenElse(hn::Eq(delta, zero), value, sum);
}

ApplyResult Apply(int8_t* values, int layers, const uint64_t* free, const WeakMisses& weak,
                  const int8_t* delta, int miss_units, int hit_units) {
  const D8 d;
  const size_t lanes = hn::Lanes(d);
  const V8 zero = hn::Zero(d), none = hn::Set(d, OccupancyField::kNoneObserved);
  const V8 miss = hn::Set(d, static_cast<int8_t>(-miss_units));
  const V8 weak_miss = hn::Set(d, static_cast<int8_t>(-weak.units)),
           above = hn::Set(d, static_cast<int8_t>(weak.above));
  const V8 hit = hn::Set(d, static_cast<int8_t>(hit_units));
  V8 max = none, min = hn::Set(d, 127), difference = zero, unknown = zero;
  for (int layer = 0; layer < layers; ++layer) {
    const uint64_t bits = free == nullptr ? ~uint64_t{0} : free[layer];
    for (size_t i = 0; i < 64; i += lanes) {
      const size_t at = 64 * static_cast<size_t>(layer) + i;
      const V8 old = hn::LoadU(d, values + at);
      V8 change = hn::IfThenElseZero(MaskOf(d, bits >> i), miss);
      if (weak.where != nullptr) {
        const M8 weaker = hn::And(MaskOf(d, (weak.where[layer] & bits) >> i), hn::Gt(old, above));
        change = hn::IfThenElse(weaker, weak_miss, change);
      }
      V8 now;
      if (delta == nullptr) {
        now = Lower(d, old, change);
      } else {
        const V8 update = hn::LoadU(d, delta + at);
        now = Update(d, old, hn::IfThenElse(hn::Eq(update, zero), change, update), hit);
      }
      hn::StoreU(now, d, values + at);
      difference = hn::Or(difference, hn::Xor(now, old));
      max = hn::Max(max, hn::IfThenElse(hn::Eq(now, zero), none, now));
      min = hn::Min(min, now);
      unknown = hn::Or(unknown, hn::VecFromMask(d, hn::Eq(now, zero)));
    }
  }
  int8_t maxima[64], minima[64];
  hn::StoreU(max, d, maxima);
  hn::StoreU(min, d, minima);
  ApplyResult result;
  int greatest = OccupancyField::kNoneObserved, least = 127;
  for (size_t i = 0; i < lanes; ++i) {
    greatest = std::max<int>(greatest, maxima[i]);
    least = std::min<int>(least, minima[i]);
  }
  result.node.max = static_cast<int8_t>(greatest);
  result.min = static_cast<int8_t>(least);
  result.node.any_unknown = !hn::AllTrue(d, hn::Eq(unknown, zero));
  result.changed = !hn::AllTrue(d, hn::Eq(difference, zero));
  return result;
}

uint32_t Saturated(const int8_t* values) {
  const D8 d;
  const V8 least = hn::Set(d, OccupancyField::kMin);
  uint32_t octants = 0;
  for (size_t half = 0; half < 2; ++half) {
    uint64_t all = ~uint64_t{0};
    for (size_t layer = 4 * half; layer < 4 * half + 4; ++layer) {
      uint64_t bits = 0;
      for (size_t i = 0; i < 64; i += hn::Lanes(d)) {
        bits |= BitsOf(d, hn::Eq(hn::LoadU(d, values + 64 * layer + i), least)) << i;
      }
      all &= bits;
    }
    for (int quarter = 0; quarter < 4; ++quarter) {
      const uint64_t bits = uint64_t{0x0f0f0f0f} << (4 * (quarter & 1) + 32 * (quarter >> 1));
      if ((all & bits) == bits) octants |= 1u << (4 * static_cast<int>(half) + quarter);
    }
  }
  return octants;
}

uint64_t Miss(int8_t* values, uint64_t which, int miss_units) {
  const D8 d;
  uint64_t changed = 0;
  const V8 miss = hn::Set(d, static_cast<int8_t>(-miss_units));
  for (size_t i = 0; i < 64; i += hn::Lanes(d)) {
    const V8 old = hn::LoadU(d, values + i);
    const V8 now = Lower(d, old, hn::IfThenElseZero(MaskOf(d, which >> i), miss));
    hn::StoreU(now, d, values + i);
    changed |= BitsOf(d, hn::Ne(now, old)) << i;
  }
  return changed;
}

}  // namespace HWY_NAMESPACE
}  // namespace atlas::mapping
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace atlas::mapping {
namespace {
HWY_EXPORT(Apply);
HWY_EXPORT(Miss);
HWY_EXPORT(Saturated);
}  // namespace

ApplyResult ApplyEvidence(int8_t* values, int layers, const uint64_t* free, const WeakMisses& weak,
                          const int8_t* delta, int miss_units, int hit_units) {
  return HWY_DYNAMIC_DISPATCH(Apply)(values, layers, free, weak, delta, miss_units, hit_units);
}

uint32_t SaturatedOctants(const int8_t* values) {
  return HWY_DYNAMIC_DISPATCH(Saturated)(values);
}

uint64_t ApplyMiss(int8_t* values, uint64_t which, int miss_units) {
  return HWY_DYNAMIC_DISPATCH(Miss)(values, which, miss_units);
}

}  // namespace atlas::mapping
#endif
