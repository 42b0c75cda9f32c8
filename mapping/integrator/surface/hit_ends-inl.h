// Hits and the voxels that hold their ends, for each SIMD target.
#if defined(ATLAS_MAPPING_INTEGRATOR_HIT_ENDS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATLAS_MAPPING_INTEGRATOR_HIT_ENDS_INL_H_
#undef ATLAS_MAPPING_INTEGRATOR_HIT_ENDS_INL_H_
#else
#define ATLAS_MAPPING_INTEGRATOR_HIT_ENDS_INL_H_
#endif

#include "mapping/integrator/projection/project-inl.h"
#include "mapping/integrator/surface/hit_trails.h"

HWY_BEFORE_NAMESPACE();
namespace atlas::mapping {
namespace HWY_NAMESPACE {

struct Vector3 {
  VF x, y, z;
};

/// Lanes(d) hits.
struct Hits {
  Vector3 p, along, inward;  ///< ends in the window, unit directions of the beams, normals
  VF range, support;         ///< support: of a voxel along the normal
  MF hit;
};

/// Eq. 4.2 at the hits' ranges.
struct Surface {
  VF band, depth, slope, miss;
  float near;

  HWY_INLINE Surface(DF d, const SurfaceModel& m, VF range)
      : band(hn::Mul(hn::Set(d, 3.0f),
                     hn::Max(hn::Set(d, m.sigma_min_voxels), hn::Mul(hn::Set(d, m.lambda_sigma), range)))),
        depth(hn::Min(hn::Max(hn::Mul(hn::Set(d, m.lambda_r), range), hn::Set(d, m.behind_min_voxels)),
                      hn::Set(d, m.behind_max_voxels))),
        slope(hn::Div(hn::Set(d, m.miss_units), band)),
        miss(hn::Set(d, m.miss_units)),
        near(static_cast<float>(m.near_units)) {}

  /// For voxels without a return, in whole steps, never 0. The surface cuts those in front of the return only
  /// just, and lies wholly before those behind.
  HWY_INLINE VI NearUnits(DF d, VF distance, int place) const {
    const DI di;
    const VF half = hn::Set(d, 0.5f), step = hn::Set(d, static_cast<float>(OccupancyField::kPlaces));
    const VF ramp = hn::Mul(slope, hn::Min(distance, hn::Mul(half, depth)));
    const VF value = hn::IfThenElse(hn::Le(distance, hn::Neg(band)), hn::Neg(miss), ramp);
    const VF steps = hn::Floor(hn::Add(hn::Mul(value, hn::Set(d, 1.0f / OccupancyField::kPlaces)), half));
    const MF before = hn::Lt(distance, hn::Zero(d));
    const VF whole = hn::Mul(
        step, hn::IfThenElse(before, hn::Min(steps, hn::Set(d, -1.0f)), hn::Max(steps, hn::Set(d, 1.0f))));
    const VI place_bits = hn::ConvertTo(di, hn::Min(whole, hn::Set(d, near)));
    return hn::Or(place_bits, hn::IfThenElseZero(hn::RebindMask(di, hn::Not(before)), hn::Set(di, place)));
  }
};

/// Signed distance of the voxels' middles behind the (shifted) planes of the hits.
HWY_INLINE VF DistanceTo(DF d, const Hits& h, const Vector3& voxel) {
  const VF half = hn::Set(d, 0.5f);
  const VF x = hn::Mul(h.inward.x, hn::Sub(hn::Add(voxel.x, half), h.p.x));
  const VF y = hn::Mul(h.inward.y, hn::Sub(hn::Add(voxel.y, half), h.p.y));
  const VF z = hn::Mul(h.inward.z, hn::Sub(hn::Add(voxel.z, half), h.p.z));
  return hn::Add(hn::Add(hn::Add(x, y), z), h.support);
}

/// Within the box of what is kept, made smaller by `margin` voxels on every side.
HWY_INLINE MF Within(DF d, const Vector3& p, const TrailRules& rules, float margin) {
  const auto within = [&](VF v, int32_t low, int32_t high) {
    return hn::And(hn::Ge(v, hn::Set(d, static_cast<float>(low) + margin)),
                   hn::Lt(v, hn::Set(d, static_cast<float>(high) - margin)));
  };
  const NodeKey &low = rules.keep_min, &high = rules.keep_max;
  return hn::And(within(p.x, low.x, high.x), hn::And(within(p.y, low.y, high.y), within(p.z, low.z, high.z)));
}
// Voxels that trails and approaches stay within.
constexpr float kTrailReach = kTrailBehind + 1, kApproachReach = HitApproaches::kVoxels + 1;

/// Where voxels of the window are held.
struct BlockSlot {
  VI block, voxel, place;  ///< as in HitTrails
  MF unallocated;          ///< in slot 0
};
/// @param asked  lanes that matter; the others' voxels may lie outside the window.
HWY_INLINE BlockSlot BlockSlotOf(DF d, const Vector3& voxel, MF asked, const ScanFrame& frame,
                                 const TrailRules& rules) {
  const DI di;
  const VI x = hn::ConvertTo(di, voxel.x), y = hn::ConvertTo(di, voxel.y), z = hn::ConvertTo(di, voxel.z);
  VI chunk = hn::Add(
      hn::ShiftRight<6>(x),
      hn::Mul(hn::Set(di, frame.chunks[0]),
              hn::Add(hn::ShiftRight<6>(y), hn::Mul(hn::Set(di, frame.chunks[1]), hn::ShiftRight<6>(z)))));
  chunk = hn::IfThenElseZero(hn::RebindMask(di, asked), chunk);
  const VI seven = hn::Set(di, 7), fifty_six = hn::Set(di, 56);
  const VI block = hn::Or(hn::And(hn::ShiftRight<3>(x), seven),
                          hn::Or(hn::And(y, fifty_six), hn::ShiftLeft<3>(hn::And(z, fifty_six))));
  BlockSlot where;
  where.voxel = hn::Or(hn::And(x, seven),
                       hn::Or(hn::ShiftLeft<3>(hn::And(y, seven)), hn::ShiftLeft<6>(hn::And(z, seven))));
  where.block = hn::Or(hn::ShiftLeft<9>(chunk), block);
  const VI row = hn::GatherIndex(di, rules.row_of_chunk, chunk);
  const VI slot = hn::GatherIndex(di, rules.slots, hn::Or(hn::ShiftLeft<9>(row), block));
  where.place = hn::Or(hn::ShiftLeft<9>(slot), where.voxel);
  where.unallocated = hn::RebindMask(d, hn::Eq(slot, hn::Zero(di)));
  return where;
}

/// Gathers held[place], int8: loads the aligned 32-bit word, shifts the byte to the top, and back with its
/// sign.
HWY_INLINE VI HeldAt(const int8_t* held, VI place) {
  const DI di;
  const VI four = hn::GatherIndex(di, reinterpret_cast<const int32_t*>(held), hn::ShiftRight<2>(place));
  const VI above = hn::Sub(hn::Set(di, 24), hn::ShiftLeft<3>(hn::And(place, hn::Set(di, 3))));
  return hn::ShiftRight<24>(hn::Shl(four, above));
}

/// Log-odds updates of the voxels that hold the ends of hits.
struct End {
  Vector3 voxel;
  VI delta;
  VI saturated_at;  ///< as in HitTrails
  MF inside;        ///< no voxel of the trail can be left out
};
HWY_INLINE End EndOf(DF d, const Hits& h, const TrailRules& rules) {
  const DI di;
  End end;
  end.voxel = {hn::Floor(h.p.x), hn::Floor(h.p.y), hn::Floor(h.p.z)};
  const VF behind = hn::Div(DistanceTo(d, h, end.voxel), hn::Add(h.support, h.support));
  const VF places = hn::Set(d, static_cast<float>(OccupancyField::kPlaces));
  const VF last = hn::Set(d, static_cast<float>(OccupancyField::kPlaces - 1));
  const VF place = hn::Min(hn::Max(hn::Floor(hn::Mul(behind, places)), hn::Zero(d)), last);
  end.delta = hn::Add(hn::Set(di, rules.model.hit_units), hn::ConvertTo(di, place));
  end.inside = Within(d, h.p, rules, kTrailReach);
  // The first hit in a voxel sets where in it the surface lies, so that no choice among many biases it.
  end.saturated_at =
      hn::IfThenElse(hn::RebindMask(di, end.inside), hn::Set(di, rules.model.hit_units), hn::Set(di, 128));
  return end;
}

/// All but ranges and normals. @param w  ends from the sensor.
HWY_INLINE void Complete(DF d, const Vector3& w, const ScanFrame& frame, Hits* h) {
  h->p = {hn::Add(w.x, hn::Set(d, frame.sensor[0])), hn::Add(w.y, hn::Set(d, frame.sensor[1])),
          hn::Add(w.z, hn::Set(d, frame.sensor[2]))};
  h->hit = hn::Gt(h->range, hn::Zero(d));
  const VF inverse = hn::Div(hn::Set(d, 1.0f), hn::IfThenElse(h->hit, h->range, hn::Set(d, 1.0f)));
  h->along = {hn::Mul(w.x, inverse), hn::Mul(w.y, inverse), hn::Mul(w.z, inverse)};
  const VF l1 = hn::Add(hn::Add(hn::Abs(h->inward.x), hn::Abs(h->inward.y)), hn::Abs(h->inward.z));
  h->support = hn::Mul(hn::Set(d, 0.5f), l1);
}

/// Appends those of the group's first 16 hits. @pre queue->count < 16.
HWY_INLINE void Append(DF d, const HitQueue& group, uint32_t which, HitQueue* queue) {
  const size_t lanes = hn::Lanes(d);
  for (size_t i = 0; i < kHitGroup; i += lanes) {
    const MF mask = MaskOf(d, which >> i);
    const auto add = [&](const float* from, float* to) {
      return hn::CompressStore(hn::Load(d, from + i), mask, d, to + queue->count);
    };
    for (size_t a = 0; a < 3; ++a) {
      add(group.end[a], queue->end[a]);
      add(group.inward[a], queue->inward[a]);
    }
    queue->count += add(group.range, queue->range);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace atlas::mapping
HWY_AFTER_NAMESPACE();

#endif
