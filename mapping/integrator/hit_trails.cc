#include "mapping/integrator/hit_trails.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/integrator/hit_trails.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "mapping/integrator/project-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atlas::mapping {
namespace HWY_NAMESPACE {

constexpr float kStill = 1e-9f;  ///< less of an axis in a direction: never crosses a voxel along it
constexpr float kNever = 1e30f;

struct Vector3 {
  VF x, y, z;
};

/// Lanes(d) hits.
struct Hits {
  Vector3 p, along, inward;  ///< ends in the window, unit directions of the beams, normals
  VF range, support;
  MF hit;
};

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

/// Eq. 4.2 at the hits' ranges.
struct Surface {
  VF band, depth, slope, miss;

  HWY_INLINE Surface(DF d, const SurfaceModel& m, VF range)
      : band(hn::Mul(hn::Set(d, 3.0f),
                     hn::Max(hn::Set(d, m.sigma_min_voxels), hn::Mul(hn::Set(d, m.lambda_sigma), range)))),
        depth(hn::Min(hn::Max(hn::Mul(hn::Set(d, m.lambda_r), range), hn::Set(d, m.behind_min_voxels)),
                      hn::Set(d, m.behind_max_voxels))),
        slope(hn::Div(hn::Set(d, m.miss_units), band)),
        miss(hn::Set(d, m.miss_units)) {}

  /// Rounded to units, never 0.
  HWY_INLINE VI Units(DF d, VF distance) const {
    const DI di;
    const VF half = hn::Set(d, 0.5f);
    const VF ramp = hn::Mul(slope, hn::Min(distance, hn::Mul(half, depth)));
    const VF value = hn::IfThenElse(hn::Le(distance, hn::Neg(band)), hn::Neg(miss), ramp);
    const VI rounded = hn::ConvertTo(di, hn::Floor(hn::Add(value, half)));
    const VI sign =
        hn::IfThenElse(hn::RebindMask(di, hn::Lt(distance, hn::Zero(d))), hn::Set(di, -1), hn::Set(di, 1));
    const VI whole = hn::IfThenElse(hn::Eq(rounded, hn::Zero(di)), sign, rounded);
    return hn::Min(hn::Max(whole, hn::Set(di, -127)), hn::Set(di, 127));
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
constexpr float kReach = HitTrails::kBehind + 1;  ///< voxels that a trail stays within

/// Stores Lanes(d) voxels of a trail; `delta` counts where `said` and the voxel is kept.
HWY_INLINE void Say(DF d, const Vector3& voxel, VI delta, MF said, bool all_kept, const ScanFrame& frame,
                    const TrailRules& rules, int at, size_t lane, HitTrails* out) {
  const DI di;
  const MF kept = all_kept ? said : hn::And(said, Within(d, voxel, rules, 0.0f));
  const uint32_t bits = BitsOf(d, kept);
  if (bits == 0) return;
  out->says[at] |= bits << lane;
  const VI x = hn::ConvertTo(di, voxel.x), y = hn::ConvertTo(di, voxel.y), z = hn::ConvertTo(di, voxel.z);
  const VI chunk = hn::Add(
      hn::ShiftRight<6>(x),
      hn::Mul(hn::Set(di, frame.chunks[0]),
              hn::Add(hn::ShiftRight<6>(y), hn::Mul(hn::Set(di, frame.chunks[1]), hn::ShiftRight<6>(z)))));
  const VI seven = hn::Set(di, 7), fifty_six = hn::Set(di, 56);
  const VI block = hn::Or(hn::And(hn::ShiftRight<3>(x), seven),
                          hn::Or(hn::And(y, fifty_six), hn::ShiftLeft<3>(hn::And(z, fifty_six))));
  const VI index = hn::Or(hn::And(x, seven),
                          hn::Or(hn::ShiftLeft<3>(hn::And(y, seven)), hn::ShiftLeft<6>(hn::And(z, seven))));
  hn::Store(hn::Or(hn::ShiftLeft<9>(chunk), block), di, out->block[at] + lane);
  hn::Store(index, di, out->voxel[at] + lane);
  const VI asked = hn::IfThenElseZero(hn::RebindMask(di, kept), chunk);
  const VI row = hn::GatherIndex(di, rules.row_of_chunk, asked);
  const VI slot = hn::GatherIndex(di, rules.slots, hn::Or(hn::ShiftLeft<9>(row), block));
  hn::Store(hn::Or(hn::ShiftLeft<9>(slot), index), di, out->place[at] + lane);
  const MF none = hn::And(kept, hn::RebindMask(d, hn::Eq(slot, hn::Zero(di))));
  out->homeless[at] |= BitsOf(d, none) << lane;
  hn::Store(delta, di, out->delta[at] + lane);
}

HWY_INLINE void WriteTrails(DF d, const Hits& h, const ScanFrame& frame, const TrailRules& rules, size_t lane,
                            HitTrails* out) {
  const DI di;
  const Surface surface(d, rules.model, h.range);
  const MF inside = Within(d, h.p, rules, kReach);  // no voxel of the trail can be left out
  const bool all_kept = hn::AllTrue(d, hn::Or(inside, hn::Not(h.hit)));
  const Vector3 end{hn::Floor(h.p.x), hn::Floor(h.p.y), hn::Floor(h.p.z)};
  const VI at_end = hn::Max(hn::Set(di, rules.model.hit_units),
                            surface.Units(d, hn::Min(DistanceTo(d, h, end), surface.depth)));
  Say(d, end, at_end, h.hit, all_kept, frame, rules, 0, lane, out);
  const MF crowded = hn::Lt(h.range, hn::Set(d, rules.crowded_range_voxels));
  const VI enough = hn::IfThenElse(hn::RebindMask(di, crowded), at_end, hn::Add(at_end, hn::Set(di, 1)));
  hn::Store(hn::IfThenElse(hn::RebindMask(di, inside), enough, hn::Set(di, 128)), di, out->said + lane);

  Walk behind = WalkFrom(d, h.p, end, h.along);
  MF goes_on = h.hit;
  for (int step = 0; step < HitTrails::kBehind; ++step) {
    behind.Next(d);
    const VF distance = DistanceTo(d, h, behind.voxel);
    goes_on = hn::And(goes_on, hn::Le(distance, surface.depth));
    if (hn::AllFalse(d, goes_on)) break;
    Say(d, behind.voxel, surface.Units(d, distance), goes_on, all_kept, frame, rules, 1 + step, lane, out);
  }
  Walk front = WalkFrom(d, h.p, end, {hn::Neg(h.along.x), hn::Neg(h.along.y), hn::Neg(h.along.z)});
  goes_on = h.hit;
  for (int step = 0; step < HitTrails::kInFront; ++step) {
    front.Next(d);
    const VF distance = DistanceTo(d, h, front.voxel);
    goes_on = hn::And(goes_on, hn::Gt(distance, hn::Neg(surface.band)));
    if (hn::AllFalse(d, goes_on)) break;
    Say(d, front.voxel, surface.Units(d, distance), goes_on, all_kept, frame, rules,
        1 + HitTrails::kBehind + step, lane, out);
  }
}

/// @param w  ends from the sensor.
HWY_INLINE void Complete(DF d, const Vector3& w, const ScanFrame& frame, Hits* h) {
  h->p = {hn::Add(w.x, hn::Set(d, frame.sensor[0])), hn::Add(w.y, hn::Set(d, frame.sensor[1])),
          hn::Add(w.z, hn::Set(d, frame.sensor[2]))};
  h->hit = hn::Gt(h->range, hn::Zero(d));
  const VF inverse = hn::Div(hn::Set(d, 1.0f), hn::IfThenElse(h->hit, h->range, hn::Set(d, 1.0f)));
  h->along = {hn::Mul(w.x, inverse), hn::Mul(w.y, inverse), hn::Mul(w.z, inverse)};
}

void CellEnds(const ScanImage& image, const float* rotation, float* const* end, float* low, float* high) {
  const DF d;
  const size_t lanes = hn::Lanes(d), cells = image.range.size();
  const VF zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  for (size_t a = 0; a < 3; ++a) {
    const VF mx = hn::Set(d, rotation[3 * a]), my = hn::Set(d, rotation[3 * a + 1]),
             mz = hn::Set(d, rotation[3 * a + 2]);
    VF least = zero, most = zero;
    for (size_t i = 0; i < cells; i += lanes) {
      const size_t at = std::min(i, cells - lanes);
      const VF r = hn::LoadU(d, image.range.data() + at);
      const VF scale = hn::IfThenElse(hn::Lt(r, zero), hn::Neg(r), hn::IfThenElseZero(hn::Gt(r, zero), one));
      const VF x = hn::Mul(hn::LoadU(d, image.x.data() + at), scale),
               y = hn::Mul(hn::LoadU(d, image.y.data() + at), scale),
               z = hn::Mul(hn::LoadU(d, image.z.data() + at), scale);
      const VF w = hn::Add(hn::Add(hn::Mul(mx, x), hn::Mul(my, y)), hn::Mul(mz, z));
      hn::StoreU(w, d, end[a] + at);
      least = hn::Min(least, w);
      most = hn::Max(most, w);
    }
    low[a] = hn::GetLane(hn::MinOfLanes(d, least));
    high[a] = hn::GetLane(hn::MaxOfLanes(d, most));
  }
}

/// Leaves out hits that add nothing to what the hit before said of the same voxel.
HWY_INLINE void DropRepeats(HitTrails* out) {
  const DF d;
  const DI di;
  const size_t lanes = hn::Lanes(di);
  alignas(64) int32_t before[3][kHitGroup + 1];
  for (size_t i = 0; i < kHitGroup; i += lanes) {
    hn::StoreU(hn::Load(di, out->block[0] + i), di, before[0] + 1 + i);
    hn::StoreU(hn::Load(di, out->voxel[0] + i), di, before[1] + 1 + i);
    hn::StoreU(hn::Load(di, out->delta[0] + i), di, before[2] + 1 + i);
  }
  before[0][0] = before[1][0] = before[2][0] = 0;
  uint32_t repeats = 0;
  for (size_t i = 0; i < kHitGroup; i += lanes) {
    const auto same = hn::And(hn::Eq(hn::LoadU(di, before[0] + i), hn::Load(di, out->block[0] + i)),
                              hn::Eq(hn::LoadU(di, before[1] + i), hn::Load(di, out->voxel[0] + i)));
    const auto enough = hn::Not(hn::Lt(hn::LoadU(di, before[2] + i), hn::Load(di, out->said + i)));
    repeats |= BitsOf(d, hn::RebindMask(d, hn::And(same, enough))) << i;
  }
  const uint32_t told = out->hits & out->says[0];
  out->hits &= ~(repeats & told & told << 1);
}

/// Nothing is said yet.
HWY_INLINE void Begin(HitTrails* out) {
  out->hits = 0;
  for (uint32_t& says : out->says) says = 0;
  for (uint32_t& homeless : out->homeless) homeless = 0;
}

void CellTrails(const ScanImage& image, const float* const end[3], size_t first, const ScanFrame& frame,
                const TrailRules& rules, HitTrails* out) {
  const DF d;
  const size_t lanes = hn::Lanes(d);
  const VF inverse = hn::Set(d, 1.0f / frame.resolution_m);
  Begin(out);
  for (size_t lane = 0; lane < kHitGroup; lane += lanes) {
    const size_t i = first + lane;
    Hits h;
    h.range = hn::Mul(hn::LoadU(d, image.range.data() + i), inverse);
    const VF nx = hn::LoadU(d, image.nx.data() + i), ny = hn::LoadU(d, image.ny.data() + i),
             nz = hn::LoadU(d, image.nz.data() + i);
    const auto inward = [&](int axis) {
      const float* m = frame.axis[axis];
      const VF sum = hn::Add(hn::Add(hn::Mul(hn::Set(d, m[0]), nx), hn::Mul(hn::Set(d, m[1]), ny)),
                             hn::Mul(hn::Set(d, m[2]), nz));
      return hn::Neg(hn::Mul(inverse, sum));
    };
    h.inward = {inward(0), inward(1), inward(2)};
    h.support = hn::Mul(hn::LoadU(d, image.support.data() + i), inverse);
    Complete(d, {hn::LoadU(d, end[0] + i), hn::LoadU(d, end[1] + i), hn::LoadU(d, end[2] + i)}, frame, &h);
    h.hit = hn::And(h.hit, Within(d, h.p, rules, -kReach));
    const uint32_t bits = BitsOf(d, h.hit);
    out->hits |= bits << lane;
    if (bits != 0) WriteTrails(d, h, frame, rules, lane, out);
  }
  DropRepeats(out);
}

void GroupTrails(const HitGroup& hits, const ScanFrame& frame, const TrailRules& rules, HitTrails* out) {
  const DF d;
  const size_t lanes = hn::Lanes(d);
  Begin(out);
  for (size_t lane = 0; lane < kHitGroup; lane += lanes) {
    const auto load = [&](const float(&v)[3][kHitGroup]) {
      return Vector3{hn::Load(d, v[0] + lane), hn::Load(d, v[1] + lane), hn::Load(d, v[2] + lane)};
    };
    Hits h;
    h.range = hn::Load(d, hits.range + lane);
    h.support = hn::Load(d, hits.support + lane);
    h.inward = load(hits.inward);
    Complete(d, load(hits.end), frame, &h);
    out->hits |= BitsOf(d, h.hit) << lane;
    WriteTrails(d, h, frame, rules, lane, out);
  }
}

uint32_t NewOfGroup(const HitTrails& trails, const int8_t* held) {
  const DF d;
  const DI di;
  const size_t lanes = hn::Lanes(di);
  uint32_t more = 0;
  for (size_t i = 0; i < kHitGroup; i += lanes) {
    const uint32_t said = trails.says[0] >> i & LaneBits(d);
    VI place = hn::Load(di, trails.place[0] + i);
    if (said == 0) continue;
    const uint64_t bits = said;
    place = hn::IfThenElseZero(hn::LoadMaskBits(di, reinterpret_cast<const uint8_t*>(&bits)), place);
    // Four bytes hold it; up to the top and, with its sign, down again.
    const VI four = hn::GatherIndex(di, reinterpret_cast<const int32_t*>(held), hn::ShiftRight<2>(place));
    const VI above = hn::Sub(hn::Set(di, 24), hn::ShiftLeft<3>(hn::And(place, hn::Set(di, 3))));
    const VI value = hn::ShiftRight<24>(hn::Shl(four, above));
    more |= BitsOf(d, hn::RebindMask(d, hn::Lt(value, hn::Load(di, trails.said + i)))) << i;
  }
  return trails.hits & (more | ~trails.says[0]);
}

void Pack(const HitTrails& trails, uint32_t hits, VoxelUpdates* out) {
  const DI di;
  const size_t lanes = hn::Lanes(di);
  size_t count = 0;
  for (int at = 0; at < HitTrails::kVoxels; ++at) {
    const uint32_t says = trails.says[at] & hits;
    if (says == 0) continue;
    for (size_t i = 0; i < kHitGroup; i += lanes) {
      const uint64_t bits = says >> i;
      const auto mask = hn::LoadMaskBits(di, reinterpret_cast<const uint8_t*>(&bits));
      hn::CompressStore(hn::Load(di, trails.delta[at] + i), mask, di, out->delta + count);
      count += hn::CompressStore(hn::Load(di, trails.place[at] + i), mask, di, out->place + count);
    }
  }
  out->count = count;
}

}  // namespace HWY_NAMESPACE
}  // namespace atlas::mapping
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace atlas::mapping {
namespace {
HWY_EXPORT(CellEnds);
HWY_EXPORT(CellTrails);
HWY_EXPORT(GroupTrails);
HWY_EXPORT(NewOfGroup);
HWY_EXPORT(Pack);
}  // namespace

void EndsOfCells(const ScanImage& image, const float rotation[9], float* const end[3], float low[3],
                 float high[3]) {
  HWY_DYNAMIC_DISPATCH(CellEnds)(image, rotation, end, low, high);
}

void TrailsOfCells(const ScanImage& image, const float* const end[3], size_t first, const ScanFrame& frame,
                   const TrailRules& rules, HitTrails* out) {
  HWY_DYNAMIC_DISPATCH(CellTrails)(image, end, first, frame, rules, out);
}

uint32_t NewHits(const HitTrails& trails, const int8_t* held) {
  return HWY_DYNAMIC_DISPATCH(NewOfGroup)(trails, held);
}

void PackUpdates(const HitTrails& trails, uint32_t hits, VoxelUpdates* out) {
  HWY_DYNAMIC_DISPATCH(Pack)(trails, hits, out);
}

void TrailsOfHits(const HitGroup& hits, const ScanFrame& frame, const TrailRules& rules, HitTrails* out) {
  HWY_DYNAMIC_DISPATCH(GroupTrails)(hits, frame, rules, out);
}

}  // namespace atlas::mapping
#endif
