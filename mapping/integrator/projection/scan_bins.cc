// Rays by the grid cell that they fall into, the one nearest to its middle in each.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/integrator/projection/scan_bins.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>

#include "mapping/integrator/projection/project-inl.h"
#include "mapping/integrator/projection/ray_bundle.h"

HWY_BEFORE_NAMESPACE();
namespace atlas::mapping {
namespace HWY_NAMESPACE {

/// Puts a ray into the cell that it falls into, unless that holds one nearer to its middle.
HWY_INLINE void BinRay(const GridColumns& image, const RayBundle& rays, size_t i, RayBins* into) {
  const BeamGrid& grid = *image.grid;
  RayBins& bins = *into;
  const float u = rays.u[i], v = rays.v[i];
  if (u < 0.0f || v < -0.5f) return;
  const auto row = static_cast<size_t>(v + 0.5f);
  if (row >= static_cast<size_t>(image.rows)) return;
  auto column = static_cast<size_t>(u + 0.5f);
  const float du = u - static_cast<float>(column), dv = v - static_cast<float>(row);
  if (column >= static_cast<size_t>(image.columns)) column -= static_cast<size_t>(image.columns);
  if (!image.Filled(column)) {
    bins.taken[i] = 1;
    return;
  }
  const float per_u = static_cast<float>(grid.column_pitch_rad) * grid.cos_elevation[row];
  const size_t bin = row * bins.pitch + column + 1;
  const auto apart = [&](float u_off, float v_off) {
    const float eu = u_off * per_u, ev = v_off * grid.row_pitch_rad[row];
    return eu * eu + ev * ev;
  };
  const float e = apart(du, dv), held = apart(bins.du[bin], bins.dv[bin]);
  if (e > held || (e == held && bins.ray[bin] < static_cast<int32_t>(i))) return;
  bins.du[bin] = du;
  bins.dv[bin] = dv;
  bins.ray[bin] = static_cast<int32_t>(i);
}

/// Lanes(d) rays. Those that fall into cells side by side, as nearly all do, go there together.
HWY_INLINE void BinVector(DF d, const GridColumns& image, const RayBundle& bundle, size_t i, RayBins* into) {
  const DI di;
  const BeamGrid& grid = *image.grid;
  RayBins& bins = *into;
  const VF half = hn::Set(d, 0.5f), zero = hn::Zero(d);
  const VF u = hn::LoadU(d, bundle.u.data() + i), v = hn::LoadU(d, bundle.v.data() + i);
  const VF row = hn::Floor(hn::Add(v, half)), column = hn::Floor(hn::Add(u, half));
  const MF in = hn::And(hn::And(hn::Ge(u, zero), hn::Ge(v, hn::Neg(half))),
                        hn::Lt(row, hn::Set(d, static_cast<float>(image.rows))));
  const VF du = hn::Sub(u, column), dv = hn::Sub(v, row);
  const VF columns = hn::Set(d, static_cast<float>(image.columns));
  const VF wrapped = hn::IfThenElse(hn::Lt(column, columns), column, hn::Sub(column, columns));
  // Exact: images have fewer than 2^24 cells.
  const VF bin = hn::Add(hn::Mul(hn::IfThenElseZero(in, row), hn::Set(d, static_cast<float>(bins.pitch))),
                         hn::Add(wrapped, hn::Set(d, 1.0f)));
  const VI rays = hn::Iota(di, static_cast<int>(i));
  ForRuns(d, hn::ConvertTo(di, bin), in, [&](int32_t first, uint32_t run) {
    const auto lane = static_cast<int32_t>(__builtin_ctz(run));
    const auto to = static_cast<size_t>(first), at = static_cast<size_t>(first + lane) / bins.pitch;
    const size_t left = static_cast<size_t>(first + lane) % bins.pitch - 1;
    const auto last = left + static_cast<size_t>(31 - __builtin_clz(run) - lane);
    if (first < 0 || to + hn::Lanes(d) > bins.count || !image.Filled(left) || !image.Filled(last)) {
      for (; run != 0; run &= run - 1)
        BinRay(image, bundle, i + static_cast<size_t>(__builtin_ctz(run)), into);
      return;
    }
    const VF per_u = hn::Set(d, static_cast<float>(grid.column_pitch_rad) * grid.cos_elevation[at]);
    const VF per_v = hn::Set(d, grid.row_pitch_rad[at]);
    const auto apart = [&](VF u_off, VF v_off) {
      const VF eu = hn::Mul(u_off, per_u), ev = hn::Mul(v_off, per_v);
      return hn::Add(hn::Mul(eu, eu), hn::Mul(ev, ev));
    };
    const VF held = apart(hn::LoadU(d, bins.du.data() + to), hn::LoadU(d, bins.dv.data() + to));
    const VF e = apart(du, dv);
    const MF first_of_equals =
        hn::And(hn::Eq(e, held), hn::RebindMask(d, hn::Lt(rays, hn::LoadU(di, bins.ray.data() + to))));
    const MF nearer = hn::And(MaskOf(d, run), hn::Or(hn::Lt(e, held), first_of_equals));
    hn::BlendedStore(du, nearer, d, bins.du.data() + to);
    hn::BlendedStore(dv, nearer, d, bins.dv.data() + to);
    hn::BlendedStore(rays, hn::RebindMask(di, nearer), di, bins.ray.data() + to);
  });
}

void BinScan(const GridColumns& image, const RayBundle& bundle, RayBins* bins) {
  const DF d;
  const size_t lanes = hn::Lanes(d), rays = bundle.count;
  size_t i = 0;
  for (; i + lanes <= rays; i += lanes) BinVector(d, image, bundle, i, bins);
  for (; i < rays; ++i) BinRay(image, bundle, i, bins);
}

}  // namespace HWY_NAMESPACE
}  // namespace atlas::mapping
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace atlas::mapping {
namespace {

HWY_EXPORT(BinScan);

constexpr float kEmptyBin = 1e9f;

}  // namespace

void BinRays(const GridColumns& grid, const RayBundle& rays, RayBins* into) {
  RayBins& bins = *into;
  const auto columns = static_cast<size_t>(grid.columns);
  bins.taken.assign(rays.count, 0);
  // `du` alone marks empty bins.
  std::fill_n(bins.du.begin(), bins.count, kEmptyBin);
  HWY_DYNAMIC_DISPATCH(BinScan)(grid, rays, into);
  for (size_t row = 0; row < static_cast<size_t>(grid.rows); ++row) {
    const size_t first = row * bins.pitch, last = first + columns + 1;
    const auto repeat = [&](size_t to, size_t from) {
      bins.du[to] = bins.du[from];
      bins.dv[to] = bins.dv[from];
      bins.ray[to] = bins.ray[from];
    };
    repeat(first, last - 1);
    repeat(last, first + 1);
  }
}

}  // namespace atlas::mapping
#endif
