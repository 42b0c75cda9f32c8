#include "mapping/integrator/surface/hit_trails.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/integrator/surface/hit_trails.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "mapping/integrator/surface/hit_ends-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atlas::mapping {
namespace HWY_NAMESPACE {

constexpr float kStill = 1e-9f;  ///< less of an axis in a direction: never crosses a voxel along it
constexpr float kNever = 1e30f;
constexpr float kApproach = 2.0f;  ///< voxels in front of the (shifted) plane: farther, the cone test decides
constexpr float kOblique = 0.5f;   ///< cosine of incidence: steeper beams leave the surface at once

/// Steps from voxel to voxel along lines (Amanatides and Woo).
struct Walk {
  Vector3 voxel, step, per_voxel, next;

  static HWY_INLINE void Begin(DF d, VF p, VF direction, VF voxel, VF* step, VF* per_voxel, VF* next) {
    const VF one = hn::Set(d, 1.0f), never = hn::Set(d, kNever);
    const VF length = hn::Abs(direction);
    const MF moves = hn::Gt(length, hn::Set(d, kStill)), up = hn::Gt(direction, hn::Zero(d));
    *step = hn::IfThenElse(up, one, hn::Neg(one));
    *per_voxel = hn::IfThenElse(moves, hn::Div(one, hn::Max(length, hn::Set(d, kStill))), never);
    const VF inside = hn::Sub(p, voxel);
    *next =
        hn::IfThenElse(moves, hn::Mul(hn::IfThenElse(up, hn::Sub(one, inside), inside), *per_voxel), never);
  }
  HWY_INLINE void Next(DF d) {
    const MF x = hn::And(hn::Lt(next.x, next.y), hn::Lt(next.x, next.z));
    const MF y = hn::AndNot(x, hn::Lt(next.y, next.z));
    const MF z = hn::Not(hn::Or(x, y));
    Advance(d, x, &voxel.x, &next.x, step.x, per_voxel.x);
    Advance(d, y, &voxel.y, &next.y, step.y, per_voxel.y);
    Advance(d, z, &voxel.z, &next.z, step.z, per_voxel.z);
  }
  static HWY_INLINE void Advance(DF, MF here, VF* voxel, VF* next, VF step, VF per_voxel) {
    *voxel = hn::Add(*voxel, hn::IfThenElseZero(here, step));
    *next = hn::Add(*next, hn::IfThenElseZero(here, per_voxel));
  }
};

HWY_INLINE Walk WalkFrom(DF d, const Vector3& p, const Vector3& voxel, const Vector3& direction) {
  Walk walk;
  walk.voxel = voxel;
  Walk::Begin(d, p.x, direction.x, voxel.x, &walk.step.x, &walk.per_voxel.x, &walk.next.x);
  Walk::Begin(d, p.y, direction.y, voxel.y, &walk.step.y, &walk.per_voxel.y, &walk.next.y);
  Walk::Begin(d, p.z, direction.z, voxel.z, &walk.step.z, &walk.per_voxel.z, &walk.next.z);
  return walk;
}

/// Stores Lanes(d) voxels of a trail; `delta` counts where `counts` and the voxel is kept.
template <int kMost>
HWY_INLINE void StoreUpdate(DF d, const Vector3& voxel, VI delta, MF counts, bool all_kept,
                            const ScanFrame& frame, const TrailRules& rules, int at, size_t lane,
                            TrailVoxels<kMost>* out) {
  const DI di;
  const MF kept = all_kept ? counts : hn::And(counts, Within(d, voxel, rules, 0.0f));
  const uint32_t bits = BitsOf(d, kept);
  if (bits == 0) return;
  const BlockSlot where = BlockSlotOf(d, voxel, kept, frame, rules);
  out->updates[at] |= bits << lane;
  out->unallocated[at] |= BitsOf(d, hn::And(kept, where.unallocated)) << lane;
  hn::Store(where.block, di, out->block[at] + lane);
  hn::Store(where.voxel, di, out->voxel[at] + lane);
  hn::Store(where.place, di, out->place[at] + lane);
  hn::Store(delta, di, out->delta[at] + lane);
}

HWY_INLINE Vector3 Reversed(const Vector3& v) {
  return {hn::Neg(v.x), hn::Neg(v.y), hn::Neg(v.z)};
}

/// @param followed  the hits that have a trail.
HWY_INLINE void WriteTrails(DF d, const Hits& h, MF followed, const ScanFrame& frame, const TrailRules& rules,
                            size_t lane, HitTrails* out) {
  const DI di;
  const Surface surface(d, rules.model, h.range);
  const End end = EndOf(d, h, rules);
  const bool all_kept = hn::AllTrue(d, hn::Or(end.inside, hn::Not(h.hit)));
  const auto store = [&](const Vector3& voxel, VI delta, MF counts, int at) {
    StoreUpdate(d, voxel, delta, counts, all_kept, frame, rules, at, lane, out);
  };
  store(end.voxel, end.delta, h.hit, 0);
  hn::Store(end.saturated_at, di, out->saturated_at + lane);

  Walk behind = WalkFrom(d, h.p, end.voxel, h.along);
  MF goes_on = followed;
  for (int step = 0; step < kTrailBehind; ++step) {
    behind.Next(d);
    const VF distance = DistanceTo(d, h, behind.voxel);
    goes_on = hn::And(goes_on, hn::Le(distance, surface.depth));
    if (hn::AllFalse(d, goes_on)) break;
    store(behind.voxel, surface.NearUnits(d, distance, OccupancyField::kPlaces - 1), goes_on, 1 + step);
  }
  Walk front = WalkFrom(d, h.p, end.voxel, Reversed(h.along));
  goes_on = followed;
  for (int step = 0; step < kTrailInFront; ++step) {
    front.Next(d);
    const VF distance = DistanceTo(d, h, front.voxel);
    goes_on = hn::And(goes_on, hn::Gt(distance, hn::Neg(surface.band)));
    if (hn::AllFalse(d, goes_on)) break;
    store(front.voxel, surface.NearUnits(d, distance, 0), goes_on, 1 + kTrailBehind + step);
  }
}

HWY_INLINE void WriteApproaches(DF d, const Hits& h, const ScanFrame& frame, const TrailRules& rules,
                                size_t lane, HitApproaches* out) {
  const Surface surface(d, rules.model, h.range);
  const Vector3 end = {hn::Floor(h.p.x), hn::Floor(h.p.y), hn::Floor(h.p.z)};
  const bool all_kept = hn::AllTrue(d, hn::Or(Within(d, h.p, rules, kApproachReach), hn::Not(h.hit)));
  Walk back = WalkFrom(d, h.p, end, Reversed(h.along));
  MF goes_on = h.hit;
  for (int step = 0; step < HitApproaches::kVoxels; ++step) {
    back.Next(d);
    const VF distance = DistanceTo(d, h, back.voxel);
    goes_on = hn::And(goes_on, hn::Gt(distance, hn::Set(d, -kApproach)));
    if (hn::AllFalse(d, goes_on)) break;
    // The first ones belong to the trail, while they are in the band.
    const MF more =
        step < kTrailInFront ? hn::And(goes_on, hn::Le(distance, hn::Neg(surface.band))) : goes_on;
    StoreUpdate(d, back.voxel, surface.NearUnits(d, distance, 0), more, all_kept, frame, rules, step, lane,
                out);
  }
}

/// The first group of a queue, Lanes(d) from `lane` on. @pre ranges beyond the queue's count are 0.
HWY_INLINE Hits HitsAt(DF d, const HitQueue& queue, const ScanFrame& frame, size_t lane) {
  const auto load = [&](const float(&v)[3][HitQueue::kRoom]) {
    return Vector3{hn::Load(d, v[0] + lane), hn::Load(d, v[1] + lane), hn::Load(d, v[2] + lane)};
  };
  Hits h;
  h.range = hn::Load(d, queue.range + lane);
  h.inward = load(queue.inward);
  Complete(d, load(queue.end), frame, &h);
  return h;
}

HWY_INLINE void FillUp(HitQueue* queue) {
  for (size_t i = queue->count; i < kHitGroup; ++i) queue->range[i] = 0.0f;
}

template <int kMost>
HWY_INLINE void Clear(TrailVoxels<kMost>* voxels) {
  for (uint32_t& updates : voxels->updates) updates = 0;
  for (uint32_t& unallocated : voxels->unallocated) unallocated = 0;
}

void Trails(const ScanFrame& frame, const TrailRules& rules, HitQueue* queue, HitTrails* out) {
  const DF d;
  FillUp(queue);
  Clear(out);
  out->hits = out->oblique = 0;
  for (size_t lane = 0; lane < kHitGroup; lane += hn::Lanes(d)) {
    const Hits h = HitsAt(d, *queue, frame, lane);
    const VF cosine = hn::Add(hn::Add(hn::Mul(h.along.x, h.inward.x), hn::Mul(h.along.y, h.inward.y)),
                              hn::Mul(h.along.z, h.inward.z));
    const MF followed = hn::AndNot(hn::Lt(cosine, hn::Set(d, rules.model.skim_cosine)), h.hit);
    const MF far = hn::Ge(h.range, hn::Set(d, rules.dense_range_voxels));
    const MF oblique = hn::And(hn::And(followed, far), hn::Lt(cosine, hn::Set(d, kOblique)));
    WriteTrails(d, h, followed, frame, rules, lane, out);
    out->hits |= BitsOf(d, h.hit) << lane;
    out->oblique |= BitsOf(d, oblique) << lane;
  }
}

void Approaches(const ScanFrame& frame, const TrailRules& rules, HitQueue* queue, HitApproaches* out) {
  const DF d;
  FillUp(queue);
  Clear(out);
  for (size_t lane = 0; lane < kHitGroup; lane += hn::Lanes(d)) {
    WriteApproaches(d, HitsAt(d, *queue, frame, lane), frame, rules, lane, out);
  }
}

void TakeFirst(uint32_t which, HitQueue* queue, HitQueue* others) {
  const DF d;
  if (which != 0) Append(d, *queue, which, others);
  const size_t lanes = hn::Lanes(d), rest = queue->count - std::min(queue->count, kHitGroup);
  const auto shift = [&](float(&v)[HitQueue::kRoom]) {
    for (size_t i = 0; i < kHitGroup; i += lanes) hn::Store(hn::Load(d, v + kHitGroup + i), d, v + i);
  };
  if (rest > 0) {
    for (auto& v : queue->end) shift(v);
    for (auto& v : queue->inward) shift(v);
    shift(queue->range);
  }
  queue->count = rest;
}

uint32_t NewOfGroup(const HitTrails& trails, const int8_t* held) {
  const DF d;
  const DI di;
  const size_t lanes = hn::Lanes(di);
  uint32_t more = 0;
  for (size_t i = 0; i < kHitGroup; i += lanes) {
    const uint32_t updated = trails.updates[0] >> i & LaneBits(d);
    VI place = hn::Load(di, trails.place[0] + i);
    if (updated == 0) continue;
    place = hn::IfThenElseZero(MaskOf(di, updated), place);
    const VI value = HeldAt(held, place);
    more |= BitsOf(d, hn::RebindMask(d, hn::Lt(value, hn::Load(di, trails.saturated_at + i)))) << i;
  }
  return trails.hits & (more | ~trails.updates[0]);
}

template <int kMost>
HWY_INLINE void PackAll(const TrailVoxels<kMost>& voxels, uint32_t hits, VoxelUpdates* out) {
  const DI di;
  const size_t lanes = hn::Lanes(di);
  size_t count = 0;
  for (int at = 0; at < kMost; ++at) {
    const uint32_t updated = voxels.updates[at] & hits;
    if (updated == 0) continue;
    for (size_t i = 0; i < kHitGroup; i += lanes) {
      const auto mask = MaskOf(di, updated >> i);
      hn::CompressStore(hn::Load(di, voxels.delta[at] + i), mask, di, out->delta + count);
      count += hn::CompressStore(hn::Load(di, voxels.place[at] + i), mask, di, out->place + count);
    }
  }
  out->count = count;
}
void PackTrails(const HitTrails& trails, uint32_t hits, VoxelUpdates* out) {
  PackAll(trails, hits, out);
}
void PackApproaches(const HitApproaches& approaches, uint32_t hits, VoxelUpdates* out) {
  PackAll(approaches, hits, out);
}

}  // namespace HWY_NAMESPACE
}  // namespace atlas::mapping
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace atlas::mapping {
namespace {
HWY_EXPORT(Trails);
HWY_EXPORT(TakeFirst);
HWY_EXPORT(NewOfGroup);
HWY_EXPORT(Approaches);
HWY_EXPORT(PackApproaches);
HWY_EXPORT(PackTrails);
}  // namespace

void FollowTrails(const ScanFrame& frame, const TrailRules& rules, HitQueue* queue, HitTrails* out) {
  HWY_DYNAMIC_DISPATCH(Trails)(frame, rules, queue, out);
}

void FollowApproaches(const ScanFrame& frame, const TrailRules& rules, HitQueue* queue, HitApproaches* out) {
  HWY_DYNAMIC_DISPATCH(Approaches)(frame, rules, queue, out);
}

void TakeGroup(uint32_t which, HitQueue* queue, HitQueue* others) {
  HWY_DYNAMIC_DISPATCH(TakeFirst)(which, queue, others);
}

uint32_t NewHits(const HitTrails& trails, const int8_t* held) {
  return HWY_DYNAMIC_DISPATCH(NewOfGroup)(trails, held);
}

void PackUpdates(const HitTrails& trails, uint32_t hits, VoxelUpdates* out) {
  HWY_DYNAMIC_DISPATCH(PackTrails)(trails, hits, out);
}

void PackUpdates(const HitApproaches& approaches, uint32_t hits, VoxelUpdates* out) {
  HWY_DYNAMIC_DISPATCH(PackApproaches)(approaches, hits, out);
}

}  // namespace atlas::mapping
#endif
