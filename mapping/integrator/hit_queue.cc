#include "mapping/integrator/hit_queue.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/integrator/hit_queue.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "mapping/integrator/hit_ends-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atlas::mapping {
namespace HWY_NAMESPACE {

void CellEnds(const ScanImage& image, const float* rotation, float* const* end, float* low, float* high) {
  const DF d;
  const size_t lanes = hn::Lanes(d), cells = image.range.size();
  const auto columns = static_cast<size_t>(image.columns);
  const VF zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  VF low_x = zero, low_y = zero, low_z = zero, high_x = zero, high_y = zero, high_z = zero;
  const auto put = [&](int a, VF x, VF y, VF z, size_t at, VF* least, VF* most) {
    const VF mx = hn::Set(d, rotation[3 * a]), my = hn::Set(d, rotation[3 * a + 1]),
             mz = hn::Set(d, rotation[3 * a + 2]);
    const VF w = hn::Add(hn::Add(hn::Mul(mx, x), hn::Mul(my, y)), hn::Mul(mz, z));
    hn::StoreU(w, d, end[a] + at);
    *least = hn::Min(*least, w);
    *most = hn::Max(*most, w);
  };
  for (size_t row = 0; row < cells; row += columns) {
    ForColumns(image, lanes, [&](size_t column) {
      const size_t at = row + column;
      const VF r = hn::LoadU(d, image.range.data() + at);
      const VF scale = hn::IfThenElse(hn::Lt(r, zero), hn::Neg(r), hn::IfThenElseZero(hn::Gt(r, zero), one));
      const VF x = hn::Mul(hn::LoadU(d, image.x.data() + at), scale),
               y = hn::Mul(hn::LoadU(d, image.y.data() + at), scale),
               z = hn::Mul(hn::LoadU(d, image.z.data() + at), scale);
      put(0, x, y, z, at, &low_x, &high_x);
      put(1, x, y, z, at, &low_y, &high_y);
      put(2, x, y, z, at, &low_z, &high_z);
    });
  }
  const VF lows[3] = {low_x, low_y, low_z}, highs[3] = {high_x, high_y, high_z};
  for (int a = 0; a < 3; ++a) {
    low[a] = hn::GetLane(hn::MinOfLanes(d, lows[a]));
    high[a] = hn::GetLane(hn::MaxOfLanes(d, highs[a]));
  }
}

/// A group of hits against what is held of their ends' voxels, and each against the one before.
struct EndGroup {
  uint32_t hits = 0, says = 0, news = 0;
  alignas(64) int32_t block[kHitGroup + 1], voxel[kHitGroup + 1], delta[kHitGroup + 1];  ///< from 1 on
  alignas(64) int32_t said[kHitGroup];

  HWY_INLINE void Store(DF d, const Hits& h, MF dense, const End& end, const ScanFrame& frame,
                        const TrailRules& rules, const int8_t* held, size_t lane) {
    const DI di;
    const MF kept = hn::And(dense, Within(d, end.voxel, rules, 0.0f));
    const Home home = HomeOf(d, end.voxel, kept, frame, rules);
    const VI value = HeldAt(held, hn::IfThenElseZero(hn::RebindMask(di, kept), home.place));
    hits |= BitsOf(d, h.hit) << lane;
    says |= BitsOf(d, kept) << lane;
    news |= BitsOf(d, hn::RebindMask(d, hn::Lt(value, end.said))) << lane;
    hn::StoreU(home.block, di, block + 1 + lane);
    hn::StoreU(home.voxel, di, voxel + 1 + lane);
    hn::StoreU(end.delta, di, delta + 1 + lane);
    hn::Store(end.said, di, said + lane);
  }
  /// The hits that add something, a bit each.
  HWY_INLINE uint32_t Telling(DF d) const {
    const DI di;
    uint32_t repeats = 0;
    for (size_t i = 0; i < kHitGroup; i += hn::Lanes(di)) {
      const auto same = hn::And(hn::Eq(hn::LoadU(di, block + i), hn::LoadU(di, block + 1 + i)),
                                hn::Eq(hn::LoadU(di, voxel + i), hn::LoadU(di, voxel + 1 + i)));
      const auto enough = hn::Not(hn::Lt(hn::LoadU(di, delta + i), hn::Load(di, said + i)));
      repeats |= BitsOf(d, hn::RebindMask(d, hn::And(same, enough))) << i;
    }
    return hits & (news | ~says) & ~(repeats & says & says << 1);
  }
};

HWY_INLINE void StoreHits(DF d, const Vector3& w, const Hits& h, size_t lane, HitQueue* out) {
  hn::Store(w.x, d, out->end[0] + lane);
  hn::Store(w.y, d, out->end[1] + lane);
  hn::Store(w.z, d, out->end[2] + lane);
  hn::Store(h.inward.x, d, out->inward[0] + lane);
  hn::Store(h.inward.y, d, out->inward[1] + lane);
  hn::Store(h.inward.z, d, out->inward[2] + lane);
  hn::Store(h.support, d, out->support + lane);
  hn::Store(h.range, d, out->range + lane);
}

void CellsToQueue(const ScanImage& image, const float* const end[3], size_t first, const ScanFrame& frame,
                  const TrailRules& rules, const int8_t* held, HitQueue* queue) {
  const DF d;
  const size_t lanes = hn::Lanes(d);
  const VF inverse = hn::Set(d, 1.0f / frame.resolution_m);
  HitQueue group;
  EndGroup ends;
  ends.block[0] = ends.voxel[0] = ends.delta[0] = 0;
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
    const Vector3 w{hn::LoadU(d, end[0] + i), hn::LoadU(d, end[1] + i), hn::LoadU(d, end[2] + i)};
    Complete(d, w, frame, &h);
    const MF close = hn::Lt(h.range, hn::Set(d, rules.dense_range_voxels));
    const MF reaches = hn::Or(Within(d, h.p, rules, -kTrailReach),
                              hn::AndNot(close, Within(d, h.p, rules, -kApproachReach)));
    h.hit = hn::And(h.hit, reaches);
    const MF dense = hn::And(h.hit, close);
    StoreHits(d, w, h, lane, &group);
    if (hn::AllFalse(d, dense)) {
      ends.hits |= BitsOf(d, h.hit) << lane;
      continue;
    }
    ends.Store(d, h, dense, EndOf(d, h, rules), frame, rules, held, lane);
  }
  Append(d, group, ends.Telling(d), queue);
}

}  // namespace HWY_NAMESPACE
}  // namespace atlas::mapping
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace atlas::mapping {
namespace {
HWY_EXPORT(CellEnds);
HWY_EXPORT(CellsToQueue);
}  // namespace

void EndsOfCells(const ScanImage& image, const float rotation[9], float* const end[3], float low[3],
                 float high[3]) {
  HWY_DYNAMIC_DISPATCH(CellEnds)(image, rotation, end, low, high);
}

void QueueCells(const ScanImage& image, const float* const end[3], size_t first, const ScanFrame& frame,
                const TrailRules& rules, const int8_t* held, HitQueue* queue) {
  HWY_DYNAMIC_DISPATCH(CellsToQueue)(image, end, first, frame, rules, held, queue);
}

}  // namespace atlas::mapping
#endif
