// Each grid cell gets the undistorted ray nearest to its direction (thesis 4.5.3, Fig. 4.7).
//
// Rays are projected to where they point from the middle of the scan and offer themselves to the cell they
// fall in; a cell then also looks at the rays of its eight neighbours, unless its own is nearer than the stop
// angle. So the search window follows the motion by itself, and costs the same for any rotation.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/integrator/scan_remap.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "mapping/integrator/project-inl.h"
#include "mapping/integrator/scan_image.h"

#ifndef ATLAS_MAPPING_SCAN_REMAP_BINS
#define ATLAS_MAPPING_SCAN_REMAP_BINS
namespace atlas::mapping {
/// A ray a cell, rows of `pitch` with a column of margin on either side.
struct Bins {
  const float *du, *dv;
  const int32_t* ray;
  size_t pitch;
};
}  // namespace atlas::mapping
#endif

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
HWY_INLINE void ProjectRays(DF d, const core::LidarScan& scan, const ColumnPoses& poses,
                            const ImageOptions& options, size_t row, size_t column, ScanImage* image) {
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
    const VectorPoint turned = Undistort(d, poses, column, i, direction, false);
    const VectorPoint point = Undistort(
        d, poses, column, i,
        {hn::Mul(direction.x, measured), hn::Mul(direction.y, measured), hn::Mul(direction.z, measured)},
        true);
    end = {hn::IfThenElse(hit, point.x, turned.x), hn::IfThenElse(hit, point.y, turned.y),
           hn::IfThenElse(hit, point.z, turned.z)};
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
  const VF u = ColumnOf(d, *image->grid, safe_x, safe_y);
  const VF v = RowOf(d, *image->grid, hn::Div(safe_z, safe_r));

  const VF limit = hn::Set(d, options.max_range_m);
  const MF near_hit = hn::And(hit, hn::Le(r, limit));
  VF range = hn::IfThenElseZero(hn::Or(hit, miss),
                                hn::IfThenElse(hit, hn::Neg(limit), hn::Set(d, -options.void_range_m)));
  range = hn::IfThenElse(near_hit, r, range);
  hn::StoreU(hn::IfThenElse(pointed, u, hn::Set(d, -1.0f)), d, image->ray_u.data() + i);
  hn::StoreU(v, d, image->ray_v.data() + i);
  const VF length = hn::IfThenElse(near_hit, hn::Set(d, 1.0f), safe_r);
  hn::StoreU(hn::Div(safe_x, length), d, image->ray_x.data() + i);
  hn::StoreU(hn::Div(safe_y, length), d, image->ray_y.data() + i);
  hn::StoreU(hn::Div(safe_z, length), d, image->ray_z.data() + i);
  hn::StoreU(hn::IfThenElseZero(pointed, range), d, image->ray_range.data() + i);
}

void ProjectScan(const core::LidarScan& scan, const ColumnPoses& poses, const ImageOptions& options,
                 ScanImage* image) {
  const DF d;
  const size_t lanes = hn::Lanes(d), columns = static_cast<size_t>(scan.columns);
  for (size_t row = 0; row < static_cast<size_t>(scan.rows); ++row) {
    for (size_t column = 0; column < columns; column += lanes) {
      ProjectRays(d, scan, poses, options, row, std::min(column, columns - lanes), image);
    }
  }
}

/// Best match of Lanes(d) cells of a row among the rays in the 3 x 3 bins around.
HWY_INLINE void MatchCells(DF d, const Bins& bins, const ImageOptions& options, int row, size_t column,
                           ScanImage* image) {
  const DI di;
  const BeamGrid& grid = *image->grid;
  const auto at = static_cast<size_t>(row);
  const VF per_u = hn::Set(d, static_cast<float>(grid.column_pitch_rad) * grid.cos_elevation[at]);
  const VF per_v = hn::Set(d, grid.row_pitch_rad[at]);
  const VF farthest = hn::Set(d, kFarthestMatch);
  VF best = hn::Set(d, kNoRay), best_du = hn::Zero(d), best_dv = hn::Zero(d);
  VI best_ray = hn::Set(di, -1);
  const auto offer = [&](int dy, int dx, MF wanted) {
    const size_t i = static_cast<size_t>(row + dy) * bins.pitch + column + static_cast<size_t>(1 + dx);
    const VF du = hn::Add(hn::LoadU(d, bins.du + i), hn::Set(d, static_cast<float>(dx)));
    const VF dv = hn::Add(hn::LoadU(d, bins.dv + i), hn::Set(d, static_cast<float>(dy)));
    const VF eu = hn::Mul(du, per_u), ev = hn::Mul(dv, per_v);
    const VF e = hn::Add(hn::Mul(eu, eu), hn::Mul(ev, ev));
    MF better =
        hn::And(hn::And(hn::Le(hn::Abs(du), farthest), hn::Le(hn::Abs(dv), farthest)), hn::Lt(e, best));
    better = hn::And(better, wanted);
    best = hn::IfThenElse(better, e, best);
    best_du = hn::IfThenElse(better, du, best_du);
    best_dv = hn::IfThenElse(better, dv, best_dv);
    best_ray = hn::IfThenElse(hn::RebindMask(di, better), hn::LoadU(di, bins.ray + i), best_ray);
  };
  offer(0, 0, hn::Lt(hn::Zero(d), hn::Set(d, 1.0f)));
  const MF wanted = hn::Gt(best, hn::Set(d, options.remap_stop_rad * options.remap_stop_rad));
  if (!hn::AllFalse(d, wanted)) {
    for (int dy = row > 0 ? -1 : 0; dy <= (row + 1 < image->rows ? 1 : 0); ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (dy != 0 || dx != 0) offer(dy, dx, wanted);
      }
    }
  }
  const size_t i = at * static_cast<size_t>(image->columns) + column;
  hn::StoreU(best_du, d, image->du.data() + i);
  hn::StoreU(best_dv, d, image->dv.data() + i);
  hn::StoreU(best_ray, di, image->cell_ray.data() + i);
  const MF matched = hn::RebindMask(d, hn::Gt(best_ray, hn::Set(di, -1)));
  const VI ray = hn::Max(best_ray, hn::Zero(di));
  hn::StoreU(hn::IfThenElseZero(matched, hn::GatherIndex(d, image->ray_range.data(), ray)), d,
             image->range.data() + i);
  hn::StoreU(hn::GatherIndex(d, image->ray_x.data(), ray), d, image->x.data() + i);
  hn::StoreU(hn::GatherIndex(d, image->ray_y.data(), ray), d, image->y.data() + i);
  hn::StoreU(hn::GatherIndex(d, image->ray_z.data(), ray), d, image->z.data() + i);
}

void MatchScan(const Bins& bins, const ImageOptions& options, ScanImage* image) {
  const DF d;
  const size_t lanes = hn::Lanes(d), columns = static_cast<size_t>(image->columns);
  for (int row = 0; row < image->rows; ++row) {
    for (size_t column = 0; column < columns; column += lanes) {
      MatchCells(d, bins, options, row, std::min(column, columns - lanes), image);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace atlas::mapping
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace atlas::mapping {
namespace {

HWY_EXPORT(ProjectScan);
HWY_EXPORT(MatchScan);

constexpr float kEmptyBin = 1e9f;

/// The ray nearest to the middle of each cell among those that fall into it.
struct BinStore {
  std::vector<float> du, dv, distance;
  std::vector<int32_t> ray;
  size_t pitch = 0;
};

void BinRays(const ScanImage& image, BinStore* bins) {
  const BeamGrid& grid = *image.grid;
  const auto columns = static_cast<size_t>(image.columns);
  bins->pitch = columns + 2;
  const size_t count = bins->pitch * static_cast<size_t>(image.rows);
  bins->du.assign(count, kEmptyBin);
  bins->dv.assign(count, kEmptyBin);
  bins->distance.assign(count, kEmptyBin);
  bins->ray.assign(count, -1);
  for (size_t i = 0; i < image.ray_u.size(); ++i) {
    const float u = image.ray_u[i], v = image.ray_v[i];
    if (u < 0.0f || v < -0.5f) continue;
    const auto row = static_cast<size_t>(v + 0.5f);
    if (row >= static_cast<size_t>(image.rows)) continue;
    auto column = static_cast<size_t>(u + 0.5f);
    const float du = u - static_cast<float>(column), dv = v - static_cast<float>(row);
    if (column >= columns) column -= columns;
    const float eu = du * static_cast<float>(grid.column_pitch_rad) * grid.cos_elevation[row];
    const float ev = dv * grid.row_pitch_rad[row];
    const float e = eu * eu + ev * ev;
    const size_t bin = row * bins->pitch + column + 1;
    if (e >= bins->distance[bin]) continue;
    bins->distance[bin] = e;
    bins->du[bin] = du;
    bins->dv[bin] = dv;
    bins->ray[bin] = static_cast<int32_t>(i);
  }
  for (size_t row = 0; row < static_cast<size_t>(image.rows); ++row) {
    const size_t first = row * bins->pitch, last = first + columns + 1;
    const auto repeat = [&](size_t to, size_t from) {
      bins->du[to] = bins->du[from];
      bins->dv[to] = bins->dv[from];
      bins->ray[to] = bins->ray[from];
    };
    repeat(first, last - 1);
    repeat(last, first + 1);
  }
}

/// Hits left over once cells have chosen.
void FindSpares(ScanImage* image) {
  image->spare.clear();
  std::vector<uint8_t> taken(image->ray_range.size(), 0);
  for (const int32_t ray : image->cell_ray) {
    if (ray >= 0) taken[static_cast<size_t>(ray)] = 1;
  }
  for (size_t i = 0; i < taken.size(); ++i) {
    if (taken[i] != 0 || image->ray_range[i] <= 0.0f) continue;
    const int row = std::clamp(static_cast<int>(image->ray_v[i] + 0.5f), 0, image->rows - 1);
    const int column = static_cast<int>(image->ray_u[i] + 0.5f) % image->columns;
    image->spare.push_back({static_cast<int32_t>(i), row * image->columns + column});
  }
}

}  // namespace

void PrepareImage(const BeamGrid& grid, ScanImage* image) {
  image->grid = &grid;
  image->rows = grid.rows;
  image->columns = grid.columns;
  image->pitch = grid.columns + ScanImage::kPad;
  const size_t cells = static_cast<size_t>(grid.rows) * static_cast<size_t>(grid.columns);
  for (auto* v : {&image->du, &image->dv, &image->range, &image->x, &image->y, &image->z, &image->nx,
                  &image->ny, &image->nz, &image->inverse_cos, &image->support}) {
    v->resize(cells);
  }
  image->cell_ray.resize(cells);
}

void RemapScan(const core::LidarScan& scan, const ColumnPoses& poses, const ImageOptions& options,
               ScanImage* image) {
  for (auto* v :
       {&image->ray_x, &image->ray_y, &image->ray_z, &image->ray_range, &image->ray_u, &image->ray_v}) {
    v->resize(scan.size());
  }
  HWY_DYNAMIC_DISPATCH(ProjectScan)(scan, poses, options, image);
  BinStore bins;
  BinRays(*image, &bins);
  HWY_DYNAMIC_DISPATCH(MatchScan)
  ({bins.du.data(), bins.dv.data(), bins.ray.data(), bins.pitch}, options, image);
  FindSpares(image);
}

}  // namespace atlas::mapping
#endif
