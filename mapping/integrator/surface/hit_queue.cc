#include "mapping/integrator/surface/hit_queue.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/integrator/surface/hit_queue.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "mapping/integrator/surface/hit_ends-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atlas::mapping {
namespace HWY_NAMESPACE {

/// Rows of the matrix from a LiDAR's metres to voxels along the map's axes.
struct ToVoxels {
  float m[3][3];
  explicit ToVoxels(const ScanFrame& frame) {
    const float inverse = 1.0f / frame.resolution_m;
    for (int a = 0; a < 3; ++a) {
      for (int c = 0; c < 3; ++c) m[a][c] = inverse * inverse * frame.axis[a][c];
    }
  }
  HWY_INLINE VF Along(DF d, int axis, VF x, VF y, VF z) const {
    return hn::Add(hn::Add(hn::Mul(hn::Set(d, m[axis][0]), x), hn::Mul(hn::Set(d, m[axis][1]), y)),
                   hn::Mul(hn::Set(d, m[axis][2]), z));
  }
};

void BoundEnds(const RangeImage& image, const ScanFrame& frame, float* low, float* high) {
  const DF d;
  const ToVoxels to(frame);
  const size_t lanes = hn::Lanes(d), cells = image.range.size();
  const auto columns = static_cast<size_t>(image.columns);
  const VF zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  VF low_x = zero, low_y = zero, low_z = zero, high_x = zero, high_y = zero, high_z = zero;
  for (size_t row = 0; row < cells; row += columns) {
    ForColumns(image, lanes, [&](size_t column) {
      const size_t at = row + column;
      const VF r = hn::LoadU(d, image.range.data() + at);
      const VF scale = hn::IfThenElse(hn::Lt(r, zero), hn::Neg(r), hn::IfThenElseZero(hn::Gt(r, zero), one));
      const VF x = hn::Mul(hn::LoadU(d, image.x.data() + at), scale),
               y = hn::Mul(hn::LoadU(d, image.y.data() + at), scale),
               z = hn::Mul(hn::LoadU(d, image.z.data() + at), scale);
      const auto widen = [&](int axis, VF* least, VF* most) {
        const VF w = to.Along(d, axis, x, y, z);
        *least = hn::Min(*least, w);
        *most = hn::Max(*most, w);
      };
      widen(0, &low_x, &high_x);
      widen(1, &low_y, &high_y);
      widen(2, &low_z, &high_z);
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
  uint32_t hits = 0, updates = 0, changed = 0;
  alignas(64) int32_t block[kHitGroup + 1], voxel[kHitGroup + 1], delta[kHitGroup + 1];  ///< from 1 on
  alignas(64) int32_t saturated_at[kHitGroup];

  HWY_INLINE void Store(DF d, const Hits& h, MF dense, const End& end, const ScanFrame& frame,
                        const TrailRules& rules, const int8_t* held, size_t lane) {
    const DI di;
    const MF kept = hn::And(dense, Within(d, end.voxel, rules, 0.0f));
    const BlockSlot where = BlockSlotOf(d, end.voxel, kept, frame, rules);
    const VI value = HeldAt(held, hn::IfThenElseZero(hn::RebindMask(di, kept), where.place));
    hits |= BitsOf(d, h.hit) << lane;
    updates |= BitsOf(d, kept) << lane;
    changed |= BitsOf(d, hn::RebindMask(d, hn::Lt(value, end.saturated_at))) << lane;
    hn::StoreU(where.block, di, block + 1 + lane);
    hn::StoreU(where.voxel, di, voxel + 1 + lane);
    hn::StoreU(end.delta, di, delta + 1 + lane);
    hn::Store(end.saturated_at, di, saturated_at + lane);
  }
  /// The hits that add something, a bit each.
  HWY_INLINE uint32_t Updating(DF d) const {
    const DI di;
    uint32_t repeats = 0;
    for (size_t i = 0; i < kHitGroup; i += hn::Lanes(di)) {
      const auto same = hn::And(hn::Eq(hn::LoadU(di, block + i), hn::LoadU(di, block + 1 + i)),
                                hn::Eq(hn::LoadU(di, voxel + i), hn::LoadU(di, voxel + 1 + i)));
      const auto enough = hn::Not(hn::Lt(hn::LoadU(di, delta + i), hn::Load(di, saturated_at + i)));
      repeats |= BitsOf(d, hn::RebindMask(d, hn::And(same, enough))) << i;
    }
    return hits & (changed | ~updates) & ~(repeats & updates & updates << 1);
  }
};

HWY_INLINE void StoreHits(DF d, const Vector3& w, const Hits& h, size_t lane, HitQueue* out) {
  hn::Store(w.x, d, out->end[0] + lane);
  hn::Store(w.y, d, out->end[1] + lane);
  hn::Store(w.z, d, out->end[2] + lane);
  hn::Store(h.inward.x, d, out->inward[0] + lane);
  hn::Store(h.inward.y, d, out->inward[1] + lane);
  hn::Store(h.inward.z, d, out->inward[2] + lane);
  hn::Store(h.range, d, out->range + lane);
}

void CellsToQueue(const SurfaceImage& surface, size_t first, const ScanFrame& frame, const TrailRules& rules,
                  const int8_t* held, HitQueue* queue) {
  const DF d;
  const RangeImage& image = *surface.image;
  const size_t lanes = hn::Lanes(d);
  const ToVoxels to(frame);
  const VF inverse = hn::Set(d, 1.0f / frame.resolution_m), inwards = hn::Set(d, -frame.resolution_m);
  HitQueue group;
  EndGroup ends;
  ends.block[0] = ends.voxel[0] = ends.delta[0] = 0;
  for (size_t lane = 0; lane < kHitGroup; lane += lanes) {
    const size_t i = first + lane;
    Hits h;
    h.range = hn::Mul(hn::LoadU(d, image.range.data() + i), inverse);
    const VF nx = hn::LoadU(d, surface.nx.data() + i), ny = hn::LoadU(d, surface.ny.data() + i),
             nz = hn::LoadU(d, surface.nz.data() + i);
    const auto inward = [&](int axis) { return hn::Mul(inwards, to.Along(d, axis, nx, ny, nz)); };
    h.inward = {inward(0), inward(1), inward(2)};
    const VF x = hn::LoadU(d, image.x.data() + i), y = hn::LoadU(d, image.y.data() + i),
             z = hn::LoadU(d, image.z.data() + i);
    const Vector3 w{to.Along(d, 0, x, y, z), to.Along(d, 1, x, y, z), to.Along(d, 2, x, y, z)};
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
  Append(d, group, ends.Updating(d), queue);
}

}  // namespace HWY_NAMESPACE
}  // namespace atlas::mapping
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace atlas::mapping {
namespace {
HWY_EXPORT(BoundEnds);
HWY_EXPORT(CellsToQueue);
}  // namespace

void BoundsOfEnds(const RangeImage& image, const ScanFrame& frame, float low[3], float high[3]) {
  HWY_DYNAMIC_DISPATCH(BoundEnds)(image, frame, low, high);
}

void QueueCells(const SurfaceImage& surface, size_t first, const ScanFrame& frame, const TrailRules& rules,
                const int8_t* held, HitQueue* queue) {
  HWY_DYNAMIC_DISPATCH(CellsToQueue)(surface, first, frame, rules, held, queue);
}

}  // namespace atlas::mapping
#endif
