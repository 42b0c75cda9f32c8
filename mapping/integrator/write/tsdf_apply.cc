#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/integrator/write/tsdf_apply.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "mapping/integrator/write/tsdf_apply.h"

HWY_BEFORE_NAMESPACE();
namespace atlas::mapping {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

bool Distances(int16_t* distance, uint8_t* weight, int layers, const uint64_t* free, const int16_t* measured,
               int16_t free_distance) {
  const hn::CappedTag<float, 16> d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::Rebind<int16_t, decltype(d)> d16;
  const hn::Rebind<uint8_t, decltype(d)> d8;
  const size_t lanes = hn::Lanes(d);
  const auto farthest = hn::Set(d, static_cast<float>(free_distance));
  const auto one = hn::Set(d, 1.0f), half = hn::Set(d, 0.5f),
             none = hn::Set(d, static_cast<float>(kNoDistance));
  const auto heaviest = hn::Set(d, static_cast<float>(TsdfField::kMaxWeight));
  bool changed = false;
  for (int layer = 0; layer < layers; ++layer) {
    const uint64_t bits = free == nullptr ? ~uint64_t{0} : free[layer];
    for (size_t i = 0; i < 64; i += lanes) {
      const size_t at = 64 * static_cast<size_t>(layer) + i;
      const uint64_t here = bits >> i;
      const auto free_here = hn::LoadMaskBits(d, reinterpret_cast<const uint8_t*>(&here));
      const auto old = hn::ConvertTo(d, hn::PromoteTo(di, hn::LoadU(d16, distance + at)));
      const auto held = hn::ConvertTo(d, hn::PromoteTo(di, hn::LoadU(d8, weight + at)));
      const auto known = hn::Gt(held, hn::Zero(d)), far = hn::Ge(old, farthest);
      // Free space implies a positive distance: no update where it is positive already, nor near a surface.
      const auto near = hn::And(known, hn::And(hn::Gt(old, hn::Zero(d)), hn::Lt(old, farthest)));
      auto value = hn::IfThenElse(hn::AndNot(near, free_here), farthest, none);
      auto w = held;
      if (measured != nullptr) {
        const auto m = hn::ConvertTo(d, hn::PromoteTo(di, hn::LoadU(d16, measured + at)));
        const auto is_measured = hn::Ne(m, none);
        value = hn::IfThenElse(is_measured, m, value);
        // A distance replaces what was only free.
        w = hn::IfThenElse(hn::And(is_measured, far), hn::Zero(d), held);
      }
      const auto update = hn::Ne(value, none);
      if (hn::AllFalse(d, update)) continue;
      // Exact: products stay below 2^24.
      const auto mean = hn::Div(hn::Add(hn::Mul(old, w), value), hn::Add(w, one));
      const auto rounded = hn::ConvertTo(di, hn::Add(mean, hn::CopySign(half, mean)));
      const auto heavier = hn::ConvertTo(di, hn::Min(hn::Add(w, one), heaviest));
      const auto mask = hn::RebindMask(di, update);
      const auto old_i = hn::ConvertTo(di, old), w_i = hn::ConvertTo(di, held);
      const auto new_i = hn::IfThenElse(mask, rounded, old_i), new_w = hn::IfThenElse(mask, heavier, w_i);
      changed = changed || !hn::AllTrue(di, hn::And(hn::Eq(new_i, old_i), hn::Eq(new_w, w_i)));
      hn::StoreU(hn::DemoteTo(d16, new_i), d16, distance + at);
      hn::StoreU(hn::DemoteTo(d8, new_w), d8, weight + at);
    }
  }
  return changed;
}

}  // namespace HWY_NAMESPACE
}  // namespace atlas::mapping
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace atlas::mapping {
namespace {
HWY_EXPORT(Distances);
}  // namespace

bool ApplyDistances(int16_t* distance, uint8_t* weight, int layers, const uint64_t* free,
                    const int16_t* measured, int16_t free_distance) {
  return HWY_DYNAMIC_DISPATCH(Distances)(distance, weight, layers, free, measured, free_distance);
}

}  // namespace atlas::mapping
#endif
