// Each grid cell gets the undistorted ray nearest to its direction (thesis 4.5.3, Fig. 4.7).
//
// Rays are projected to where they point from the middle of the scan and offer themselves to the cell they
// fall in; a cell then also looks at the rays of its eight neighbours, unless its own is nearer than the stop
// angle. So the search window follows the motion by itself, and costs the same for any rotation.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/integrator/projection/scan_remap.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cstring>

#include "core/parallel_for.h"
#include "mapping/integrator/projection/project-inl.h"
#include "mapping/integrator/projection/range_image.h"

HWY_BEFORE_NAMESPACE();
namespace atlas::mapping {
namespace HWY_NAMESPACE {

/// A ray farther than this from the cell's direction, in cells along either axis, is no match for it.
constexpr float kFarthestMatch = 0.75f;
constexpr float kNoRay = 1e9f;

struct VectorPoint {
  VF x, y, z;
};

/// T_mid_lidar * p at the rays' own times.
HWY_INLINE VectorPoint Undistort(DF d, const ColumnPoses& poses, size_t column, size_t ray, VectorPoint p,
                                 bool point) {
  const DI di;
  VF m[12];
  for (size_t e = 0; e < 12; ++e) {
    const float* entry = poses.T_mid_lidar[e].data();
    m[e] = poses.pose_of_ray.empty()
               ? hn::LoadU(d, entry + column)
               : hn::GatherIndex(d, entry, hn::LoadU(di, poses.pose_of_ray.data() + ray));
  }
  const auto row = [&](size_t r) {
    VF s = hn::Add(hn::Add(hn::Mul(m[4 * r], p.x), hn::Mul(m[4 * r + 1], p.y)), hn::Mul(m[4 * r + 2], p.z));
    return point ? hn::Add(s, m[4 * r + 3]) : s;
  };
  return {row(0), row(1), row(2)};
}

/// Projects Lanes(d) rays of a row from `column` on.
HWY_INLINE void ProjectRays(DF d, const RaySource& source, size_t row, size_t column, RayBundle* rays) {
  const core::LidarScan& scan = source.scan;
  const ColumnPoses& poses = source.poses;
  const ImageOptions& options = source.options;
  const DI di;
  const hn::Rebind<uint8_t, DI> d8;
  const size_t i = row * static_cast<size_t>(scan.columns) + column;
  VectorPoint direction;
  hn::LoadInterleaved3(d, scan.direction_lidar[i].data(), direction.x, direction.y, direction.z);
  const VI kind = hn::PromoteTo(di, hn::LoadU(d8, reinterpret_cast<const uint8_t*>(scan.kind.data()) + i));
  const VF measured = hn::LoadU(d, scan.range_m.data() + i);
  const MF hit = hn::RebindMask(d, hn::Eq(kind, hn::Set(di, static_cast<int>(core::ReturnKind::kHit))));
  const MF miss = hn::RebindMask(d, hn::Eq(kind, hn::Set(di, static_cast<int>(core::ReturnKind::kVoid))));

  VectorPoint end = direction;
  if (poses.moving) {
    end = Undistort(
        d, poses, column, i,
        {hn::Mul(direction.x, measured), hn::Mul(direction.y, measured), hn::Mul(direction.z, measured)},
        true);
    if (!hn::AllTrue(d, hit)) {
      const VectorPoint turned = Undistort(d, poses, column, i, direction, false);
      end = {hn::IfThenElse(hit, end.x, turned.x), hn::IfThenElse(hit, end.y, turned.y),
             hn::IfThenElse(hit, end.z, turned.z)};
    }
  } else {
    const VF scale = hn::IfThenElse(hit, measured, hn::Set(d, 1.0f));
    end = {hn::Mul(direction.x, scale), hn::Mul(direction.y, scale), hn::Mul(direction.z, scale)};
  }
  const VF r2 = hn::Add(hn::Add(hn::Mul(end.x, end.x), hn::Mul(end.y, end.y)), hn::Mul(end.z, end.z));
  const VF r = hn::Sqrt(r2);
  // Also false for NaN: such a ray has no direction and no range.
  const MF pointed = hn::And(hn::Gt(r, hn::Set(d, 1e-3f)), hn::Lt(r, hn::Set(d, 1e6f)));
  const VF safe_r = hn::IfThenElse(pointed, r, hn::Set(d, 1.0f));
  const VF safe_x = hn::IfThenElseZero(pointed, end.x), safe_y = hn::IfThenElseZero(pointed, end.y),
           safe_z = hn::IfThenElseZero(pointed, end.z);
  const VF u = ColumnOf(d, source.grid, safe_x, safe_y);
  const VF v = RowOf(d, source.grid, hn::Div(safe_z, safe_r));

  const VF limit = hn::Set(d, options.max_range_m);
  const MF near_hit = hn::And(hit, hn::Le(r, limit));
  VF range = hn::IfThenElseZero(hn::Or(hit, miss),
                                hn::IfThenElse(hit, hn::Neg(limit), hn::Set(d, -options.void_range_m)));
  range = hn::IfThenElse(near_hit, r, range);
  // Rays are kept by ascending azimuth, as the grid's columns are.
  const bool turned_round = source.grid.clockwise;
  const size_t mirrored = static_cast<size_t>(scan.columns) - hn::Lanes(d) - column;
  const size_t to = row * static_cast<size_t>(scan.columns) + (turned_round ? mirrored : column);
  const auto store = [&](VF value, std::vector<float>& out) {
    hn::StoreU(turned_round ? hn::Reverse(d, value) : value, d, out.data() + to);
  };
  store(hn::IfThenElse(pointed, u, hn::Set(d, -1.0f)), rays->u);
  store(v, rays->v);
  VF shorter = hn::Set(d, 1.0f);
  if (!hn::AllTrue(d, near_hit)) shorter = hn::IfThenElse(near_hit, shorter, hn::Div(shorter, safe_r));
  store(hn::Mul(safe_x, shorter), rays->x);
  store(hn::Mul(safe_y, shorter), rays->y);
  store(hn::Mul(safe_z, shorter), rays->z);
  store(hn::IfThenElseZero(pointed, range), rays->range);
}

void ProjectRows(const RaySource& source, size_t begin, size_t end, RayBundle* rays) {
  const DF d;
  const size_t lanes = hn::Lanes(d), columns = static_cast<size_t>(source.scan.columns);
  for (size_t row = begin; row < end; ++row) {
    for (size_t column = 0; column < columns; column += lanes) {
      ProjectRays(d, source, row, std::min(column, columns - lanes), rays);
    }
  }
}

/// Ranges and ends of the rays that Lanes(d) cells from `i` on chose (-1: none); returns how far they reach.
HWY_INLINE VF FetchRays(DF d, const RayBundle& bundle, VI best_ray, size_t i, RangeImage* image) {
  const DI di;
  VF range = hn::Zero(d), x = range, y = range, z = range;
  ForRuns(d, best_ray, hn::RebindMask(d, hn::Gt(best_ray, hn::Set(di, -1))),
          [&](int32_t first, uint32_t run) {
            const MF mask = MaskOf(d, run);
            const auto from = static_cast<size_t>(first);
            const bool within = first >= 0 && from + hn::Lanes(d) <= bundle.count;
            const auto fetch = [&](const std::vector<float>& rays, VF* to) {
              const VF values = within ? hn::LoadU(d, rays.data() + from)
                                       : hn::GatherIndex(d, rays.data(), hn::Max(best_ray, hn::Zero(di)));
              *to = hn::IfThenElse(mask, values, *to);
            };
            fetch(bundle.range, &range);
            fetch(bundle.x, &x);
            fetch(bundle.y, &y);
            fetch(bundle.z, &z);
          });
  hn::StoreU(range, d, image->range.data() + i);
  hn::StoreU(x, d, image->x.data() + i);
  hn::StoreU(y, d, image->y.data() + i);
  hn::StoreU(z, d, image->z.data() + i);
  return hn::Abs(range);
}

/// Best match of Lanes(d) cells of a row among the rays in the 3 x 3 bins around; returns how far they reach.
HWY_INLINE VF MatchVector(DF d, const RayOffers& offers, int row, size_t column, RangeImage* image) {
  const DI di;
  const RayBins& bins = offers.bins;
  const BeamGrid& grid = *image->grid;
  const auto at = static_cast<size_t>(row);
  const VF per_u = hn::Set(d, static_cast<float>(grid.column_pitch_rad) * grid.cos_elevation[at]);
  const VF per_v = hn::Set(d, grid.row_pitch_rad[at]);
  const VF farthest = hn::Set(d, kFarthestMatch);
  VF best = hn::Set(d, kNoRay), best_du = hn::Zero(d), best_dv = hn::Zero(d);
  VI best_ray = hn::Set(di, -1);
  const auto offer = [&](int dy, int dx, MF wanted) {
    const size_t i = static_cast<size_t>(row + dy) * bins.pitch + column + static_cast<size_t>(1 + dx);
    const VF du = hn::Add(hn::LoadU(d, bins.du.data() + i), hn::Set(d, static_cast<float>(dx)));
    const VF dv = hn::Add(hn::LoadU(d, bins.dv.data() + i), hn::Set(d, static_cast<float>(dy)));
    const VF eu = hn::Mul(du, per_u), ev = hn::Mul(dv, per_v);
    const VF e = hn::Add(hn::Mul(eu, eu), hn::Mul(ev, ev));
    MF better =
        hn::And(hn::And(hn::Le(hn::Abs(du), farthest), hn::Le(hn::Abs(dv), farthest)), hn::Lt(e, best));
    better = hn::And(better, wanted);
    best = hn::IfThenElse(better, e, best);
    best_du = hn::IfThenElse(better, du, best_du);
    best_dv = hn::IfThenElse(better, dv, best_dv);
    best_ray = hn::IfThenElse(hn::RebindMask(di, better), hn::LoadU(di, bins.ray.data() + i), best_ray);
  };
  offer(0, 0, hn::Lt(hn::Zero(d), hn::Set(d, 1.0f)));
  // Rays in other columns, or rows, lie at least half a cell off: nearer ones need no look at them.
  const float stop2 = offers.stop_rad * offers.stop_rad;
  const float half_u = 0.5f * hn::GetLane(per_u), half_v = 0.5f * hn::GetLane(per_v);
  const MF beside = hn::Gt(best, hn::Set(d, std::max(stop2, half_u * half_u)));
  const MF above = hn::Gt(best, hn::Set(d, std::max(stop2, half_v * half_v)));
  if (!hn::AllFalse(d, beside)) {
    offer(0, -1, beside);
    offer(0, 1, beside);
  }
  if (!hn::AllFalse(d, above)) {
    for (int dy = -1; dy <= 1; dy += 2) {
      if (row + dy < 0 || row + dy >= image->rows) continue;
      for (int dx = -1; dx <= 1; ++dx) offer(dy, dx, above);
    }
  }
  const size_t i = at * static_cast<size_t>(image->columns) + column;
  hn::StoreU(PackOffsets(d, best_du, best_dv), di, image->offset.data() + i);
  hn::StoreU(best_ray, di, image->cell_ray.data() + i);
  return FetchRays(d, offers.rays, best_ray, i, image);
}

/// Marks the rays that cells chose.
void MarkTaken(const RangeImage& image, RayBins* bins) {
  const DF d;
  const DI di;
  const hn::Rebind<uint8_t, DI> d8;
  const size_t lanes = hn::Lanes(di), columns = static_cast<size_t>(image.columns);
  const auto one = hn::Set(d8, 1);
  const auto mark = [&](size_t at) {
    const VI rays = hn::LoadU(di, image.cell_ray.data() + at);
    ForRuns(d, rays, hn::RebindMask(d, hn::Gt(rays, hn::Set(di, -1))), [&](int32_t first, uint32_t run) {
      if (first < 0 || static_cast<size_t>(first) + lanes > bins->taken.size()) {
        for (; run != 0; run &= run - 1) bins->taken[static_cast<size_t>(first + __builtin_ctz(run))] = 1;
        return;
      }
      hn::BlendedStore(one, MaskOf(d8, run), d8, bins->taken.data() + first);
    });
  };
  for (size_t row = 0; row < static_cast<size_t>(image.rows); ++row) {
    ForColumns(image, lanes, [&](size_t column) { mark(row * columns + column); });
  }
}

/// Returns how far their matches reach, metres.
float MatchRows(const RayOffers& offers, size_t begin, size_t end, RangeImage* image) {
  const DF d;
  const size_t lanes = hn::Lanes(d);
  VF reach = hn::Zero(d);
  for (size_t row = begin; row < end; ++row) {
    ForColumns(*image, lanes, [&](size_t column) {
      reach = hn::Max(reach, MatchVector(d, offers, static_cast<int>(row), column, image));
    });
  }
  return hn::GetLane(hn::MaxOfLanes(d, reach));
}

}  // namespace HWY_NAMESPACE
}  // namespace atlas::mapping
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace atlas::mapping {
namespace {

HWY_EXPORT(ProjectRows);
HWY_EXPORT(MatchRows);
HWY_EXPORT(MarkTaken);

/// Hits left over once cells have chosen.
void FindSpares(const RayBundle& rays, const RayBins& bins, RangeImage* image) {
  image->spare.clear();
  const std::vector<uint8_t>& taken = bins.taken;
  const auto add = [&](size_t i) {
    if (taken[i] != 0 || rays.range[i] <= 0.0f) return;
    const int row = std::clamp(static_cast<int>(rays.v[i] + 0.5f), 0, image->rows - 1);
    const int column = static_cast<int>(rays.u[i] + 0.5f) % image->columns;
    if (!image->Filled(static_cast<size_t>(column))) return;
    image->spare.push_back({row * image->columns + column, rays.range[i], {rays.x[i], rays.y[i], rays.z[i]}});
  };
  size_t i = 0;
  for (; i + 8 <= taken.size(); i += 8) {
    uint64_t eight;
    std::memcpy(&eight, taken.data() + i, sizeof eight);
    if (eight == 0x0101010101010101u) continue;
    for (size_t k = i; k < i + 8; ++k) add(k);
  }
  for (; i < taken.size(); ++i) add(i);
}

}  // namespace

RangeImage::RangeImage(const BeamGrid& beams) : GridColumns(beams) {
  for (auto* v : {&range, &x, &y, &z}) v->resize(cells());
  cell_ray.resize(cells());
  offset.resize(cells());
}

void ProjectScan(const RaySource& source, RayBundle* rays) {
  const auto rows = static_cast<size_t>(source.scan.rows);
  core::ParallelFor(source.options.threads, rows, [&](size_t begin, size_t end, size_t) {
    HWY_DYNAMIC_DISPATCH(ProjectRows)(source, begin, end, rays);
  });
}

void MatchCells(const RayBundle& rays, const ImageOptions& options, RayBins* bins, RangeImage* image) {
  const RayOffers offers{rays, *bins, options.remap_stop_rad};
  std::vector<float> reach_m(static_cast<size_t>(std::max(options.threads, 1)), 0.0f);
  const auto rows = static_cast<size_t>(image->rows);
  core::ParallelFor(options.threads, rows, [&](size_t begin, size_t end, size_t worker) {
    reach_m[worker] = HWY_DYNAMIC_DISPATCH(MatchRows)(offers, begin, end, image);
  });
  image->reach_m = *std::max_element(reach_m.begin(), reach_m.end());
  HWY_DYNAMIC_DISPATCH(MarkTaken)(*image, bins);
  FindSpares(rays, *bins, image);
}

}  // namespace atlas::mapping
#endif
