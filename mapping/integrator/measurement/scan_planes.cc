// The plane of the surface through each hit, from the hits around it.
//
// On a plane the inverse range is linear in the angle (for small steps), so slopes are taken from inverse
// ranges: exact at any incidence. Each axis takes the mean slope where both neighbours continue one plane,
// else the flatter side, else none (a lone return counts as seen head on). Near the sensor neighbours lie
// several beams off, so that range noise does not tilt the plane.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/integrator/measurement/scan_planes.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

#include "core/parallel_for.h"
#include "mapping/integrator/measurement/margins.h"
#include "mapping/integrator/projection/project-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atlas::mapping {
namespace HWY_NAMESPACE {

constexpr float kBaselineM = 0.10f;
constexpr int kWidestColumns = 8, kWidestRows = 4;
constexpr float kBendShare = 0.25f;    ///< of the slopes: what two sides of one plane may differ by
constexpr float kRangeNoiseM = 0.06f;  ///< of a second difference of ranges
constexpr float kStepSlope = 4.0f;     ///< steeper on both sides, apart: a thin thing or a gap
constexpr float kLeastAngle = 1e-3f;   ///< between rows
constexpr float kGrazing = 60.0f;      ///< greatest 1 / cos(incidence) that counts

/// d(range) / d(angle) / range on one side, where that side has a hit.
struct Side {
  VF slope;
  MF hit;
};

/// value(k) where steps are k, powers of two up to `widest`: mostly all share one.
template <typename Value>
HWY_INLINE VF ByStep(DF d, VI steps, int widest, const Value& value) {
  const DI di;
  const int first = hn::GetLane(steps);
  VF out = value(first);
  const auto others = hn::Ne(steps, hn::Set(di, first));
  if (hn::AllFalse(di, others)) return out;
  for (int k = 1; k <= widest; k *= 2) {
    const auto here = hn::And(others, hn::Eq(steps, hn::Set(di, k)));
    if (!hn::AllFalse(di, here)) out = hn::IfThenElse(hn::RebindMask(d, here), value(k), out);
  }
  return out;
}

/// Ranges `along` columns beside `column` on, across the seam too.
HWY_INLINE VF RangeBeside(DF d, const RangeImage& image, int row, size_t column, int along) {
  const DI di;
  const float* ranges = image.range.data() + static_cast<size_t>(row) * static_cast<size_t>(image.columns);
  const int first = static_cast<int>(column) + along;
  if (first >= 0 && first + static_cast<int>(hn::Lanes(d)) <= image.columns)
    return hn::LoadU(d, ranges + first);
  const VI columns = hn::Set(di, image.columns);
  VI c = hn::Iota(di, first);
  c = hn::IfThenElse(hn::Lt(c, hn::Zero(di)), hn::Add(c, columns), c);
  c = hn::IfThenElse(hn::Gt(c, hn::Set(di, image.columns - 1)), hn::Sub(c, columns), c);
  return hn::GatherIndex(d, ranges, c);
}
/// Ranges `down` rows below; not hits outside the image.
HWY_INLINE VF RangeBelow(DF d, const RangeImage& image, int row, size_t column, int down) {
  if (row + down < 0 || row + down >= image.rows) return hn::Zero(d);
  return RangeBeside(d, image, row + down, column, 0);
}

/// @param per_angle  1 over the angle to the neighbour, negative where it lies towards smaller angle.
HWY_INLINE Side SlopeTo(DF d, VF range, VF neighbour, VF per_angle) {
  const MF hit = hn::Gt(neighbour, hn::Zero(d));
  const VF ratio = hn::Div(range, hn::IfThenElse(hit, neighbour, range));
  return {hn::Mul(hn::Sub(hn::Set(d, 1.0f), ratio), per_angle), hit};
}

HWY_INLINE VF JoinSides(DF d, Side a, Side b, VF q, VF per_angle) {
  const VF zero = hn::Zero(d);
  const MF both = hn::And(a.hit, b.hit);
  const VF bend = hn::Abs(hn::Sub(a.slope, b.slope));
  const VF allowed = hn::Add(hn::Mul(hn::Add(hn::Abs(a.slope), hn::Abs(b.slope)), hn::Set(d, kBendShare)),
                             hn::Mul(hn::Mul(q, hn::Set(d, kRangeNoiseM)), per_angle));
  const VF mean = hn::Mul(hn::Add(a.slope, b.slope), hn::Set(d, 0.5f));
  const VF flatter = hn::IfThenElse(hn::Lt(hn::Abs(a.slope), hn::Abs(b.slope)), a.slope, b.slope);
  const VF steep = hn::Set(d, kStepSlope);
  const MF apart = hn::And(hn::Lt(hn::Mul(a.slope, b.slope), zero),
                           hn::And(hn::Gt(hn::Abs(a.slope), steep), hn::Gt(hn::Abs(b.slope), steep)));
  const VF two = hn::IfThenElse(hn::Le(bend, allowed), mean, hn::IfThenElse(apart, zero, flatter));
  const VF one = hn::IfThenElse(a.hit, a.slope, hn::IfThenElseZero(b.hit, b.slope));
  return hn::IfThenElse(both, two, one);
}

/// How many cells apart neighbours are taken, so that they lie kBaselineM apart.
HWY_INLINE VI StepsFor(DF d, VF q, float pitch_rad, int widest) {
  const DI di;
  const VF steps = hn::Mul(q, hn::Set(d, kBaselineM / pitch_rad));
  const VF most = hn::Set(d, static_cast<float>(widest));
  const VI whole = hn::BitCast(di, hn::Min(hn::Max(steps, hn::Set(d, 1.0f)), most));
  // Down to a power of two, which neighbours mostly share.
  return FloorPositive(di, hn::BitCast(d, hn::And(whole, hn::Set(di, 0x7f800000))));
}

struct Slopes {
  VF azimuth, elevation;
};

HWY_INLINE Slopes SlopesOf(DF d, const RangeImage& image, int row, size_t column, VF range) {
  const BeamGrid& grid = *image.grid;
  const auto at = static_cast<size_t>(row);
  const VF q = hn::Div(hn::Set(d, 1.0f), range);
  const float pitch_u = static_cast<float>(grid.column_pitch_rad) * grid.cos_elevation[at];
  const VI ku = StepsFor(d, q, pitch_u, kWidestColumns);
  const VF one = hn::Set(d, 1.0f);
  const VF per_u = hn::Div(one, hn::Mul(hn::ConvertTo(d, ku), hn::Set(d, pitch_u)));
  const auto beside = [&](int sign) {
    return ByStep(d, ku, kWidestColumns, [&](int k) { return RangeBeside(d, image, row, column, sign * k); });
  };
  const Side right = SlopeTo(d, range, beside(1), per_u);
  const Side left = SlopeTo(d, range, beside(-1), hn::Neg(per_u));

  const VI kv = StepsFor(d, q, grid.row_pitch_rad[at], kWidestRows);
  const auto angle = [&](int k) {
    const auto other = static_cast<size_t>(std::clamp(row + k, 0, image.rows - 1));
    return std::max(kLeastAngle, std::abs(grid.elevation_rad[at] - grid.elevation_rad[other]));
  };
  const auto below_by = [&](int sign) {
    return ByStep(d, kv, kWidestRows, [&](int k) { return RangeBelow(d, image, row, column, sign * k); });
  };
  const auto per_angle = [&](int sign) {
    return ByStep(d, kv, kWidestRows,
                  [&](int k) { return hn::Set(d, -1.0f * static_cast<float>(sign) / angle(sign * k)); });
  };
  const Side above = SlopeTo(d, range, below_by(-1), per_angle(-1));
  const Side below = SlopeTo(d, range, below_by(1), per_angle(1));
  const VF per_v =
      ByStep(d, kv, kWidestRows, [&](int k) { return hn::Set(d, 2.0f / (angle(k) + angle(-k))); });
  return {JoinSides(d, right, left, q, per_u), JoinSides(d, above, below, q, per_v)};
}

/// Of planes: 1 / cos(incidence), bounded, and the voxel's support along the normal.
struct Lean {
  VF inverse_cos, support;
};

/// Turns slopes into the normal: the slopes are the range's growth a row and a column.
HWY_INLINE Lean StorePlane(DF d, const float* rotation, float half_voxel, Slopes slope, VF range, size_t i,
                           SurfaceImage* surface) {
  const VF one = hn::Set(d, 1.0f);
  const RangeImage& image = *surface->image;
  const VF x = hn::LoadU(d, image.x.data() + i), y = hn::LoadU(d, image.y.data() + i),
           z = hn::LoadU(d, image.z.data() + i);
  const VF inverse_range = hn::Div(one, range);
  const VF rx = hn::Mul(x, inverse_range), ry = hn::Mul(y, inverse_range), rz = hn::Mul(z, inverse_range);
  const VF flat = hn::Max(hn::Sqrt(hn::Add(hn::Mul(rx, rx), hn::Mul(ry, ry))), hn::Set(d, 1e-4f));
  const VF ca = hn::Div(rx, flat), sa = hn::Div(ry, flat);
  const VF t2 =
      hn::Add(hn::Add(one, hn::Mul(slope.azimuth, slope.azimuth)), hn::Mul(slope.elevation, slope.elevation));
  const VF t = hn::Sqrt(t2);
  const VF scale = hn::Div(one, t);
  // away = r - g_azimuth e_azimuth - g_elevation e_elevation; the normal is -away / |away|.
  const VF gu = slope.azimuth, gv = slope.elevation;
  const VF ax = hn::Add(hn::Add(rx, hn::Mul(gu, sa)), hn::Mul(gv, hn::Mul(rz, ca)));
  const VF ay = hn::Add(hn::Sub(ry, hn::Mul(gu, ca)), hn::Mul(gv, hn::Mul(rz, sa)));
  const VF az = hn::Sub(rz, hn::Mul(gv, flat));
  const VF nx = hn::Neg(hn::Mul(ax, scale)), ny = hn::Neg(hn::Mul(ay, scale)),
           nz = hn::Neg(hn::Mul(az, scale));
  VF l1 = hn::Zero(d);
  for (int r = 0; r < 3; ++r) {
    const VF c = hn::Add(
        hn::Add(hn::Mul(nx, hn::Set(d, rotation[3 * r])), hn::Mul(ny, hn::Set(d, rotation[3 * r + 1]))),
        hn::Mul(nz, hn::Set(d, rotation[3 * r + 2])));
    l1 = hn::Add(l1, hn::Abs(c));
  }
  hn::StoreU(nx, d, surface->nx.data() + i);
  hn::StoreU(ny, d, surface->ny.data() + i);
  hn::StoreU(nz, d, surface->nz.data() + i);
  return {hn::Min(t, hn::Set(d, kGrazing)), hn::Mul(l1, hn::Set(d, half_voxel))};
}

/// The nearer of the range of the return and of its plane in the cell's own direction, which the beam may
/// miss by most of a cell (cells are looked up by their directions).
HWY_INLINE VF RangeOfCell(DF d, const RangeImage& image, const Slopes& slope, VF range, int row, size_t i) {
  const BeamGrid& grid = *image.grid;
  const auto at = static_cast<size_t>(row);
  const float pitch_u = static_cast<float>(grid.column_pitch_rad) * grid.cos_elevation[at];
  // Elevations fall as rows grow. 1 / range is linear in the angle.
  const Offsets ray = UnpackOffsets(d, hn::LoadU(DI(), image.offset.data() + i));
  const VF along_u = hn::Mul(slope.azimuth, hn::Mul(ray.u, hn::Set(d, pitch_u)));
  const VF along_v = hn::Mul(slope.elevation, hn::Mul(ray.v, hn::Set(d, grid.row_pitch_rad[at])));
  const VF grows = hn::Sub(along_u, along_v);
  const VF factor = hn::Add(hn::Set(d, 1.0f), hn::Min(hn::Max(grows, hn::Zero(d)), hn::Set(d, 1.0f)));
  return hn::Div(range, factor);
}

/// Free up to where a voxel could touch the surface: 3 sigma and its support off the plane. The own beam
/// keeps twice the support away, since a voxel that it pierces may hang below it by as much.
HWY_INLINE void StoreMargins(DF d, const ImageOptions& options, const Lean& lean, VF range, MF hit, int row,
                             size_t column, size_t i, Margins* margins) {
  const size_t to = static_cast<size_t>(row) * static_cast<size_t>(margins->pitch) + column;
  const VF t = lean.inverse_cos, h = lean.support;
  const VF sigma = hn::Max(hn::Set(d, options.sigma_min_m), hn::Mul(range, hn::Set(d, options.lambda_sigma)));
  const VF band = hn::Mul(hn::Set(d, 3.0f), sigma);
  const VF least = hn::Set(d, 0.002f);
  const VF miss = hn::Neg(hn::Min(hn::LoadU(d, margins->image->range.data() + i), hn::Zero(d)));
  for (int k = 0; (1 << k) <= options.max_scale; ++k) {
    const VF reach = hn::Mul(h, hn::Set(d, static_cast<float>(1 << k)));
    const VF veto = hn::Sub(range, hn::Mul(hn::Add(reach, band), t));
    const VF own = hn::Sub(veto, hn::Mul(reach, hn::Sub(t, hn::Set(d, 1.0f))));
    const auto s = static_cast<size_t>(k);
    const size_t below_top = to + static_cast<size_t>(margins->pitch);
    hn::StoreU(hn::IfThenElse(hit, hn::Max(own, least), miss), d, margins->own[s].data() + to);
    hn::StoreU(hn::IfThenElse(hit, hn::Max(veto, least), miss), d, margins->surround[s].data() + below_top);
  }
}

void PlanesOfRows(const float* rotation, const ImageOptions& options, size_t begin, size_t end,
                  const PlanesOut& out) {
  const DF d;
  const RangeImage& image = *out.surface->image;
  const size_t lanes = hn::Lanes(d), columns = static_cast<size_t>(image.columns);
  for (int row = static_cast<int>(begin); row < static_cast<int>(end); ++row) {
    ForColumns(image, lanes, [&](size_t column) {
      const size_t i = static_cast<size_t>(row) * columns + column;
      const VF signed_range = hn::LoadU(d, image.range.data() + i);
      const MF hit = hn::Gt(signed_range, hn::Zero(d));
      const VF range = hn::IfThenElse(hit, signed_range, hn::Set(d, 1.0f));
      VF free_range = range;
      Lean lean{hn::Zero(d), hn::Zero(d)};
      if (!hn::AllFalse(d, hit)) {
        const Slopes slopes = SlopesOf(d, image, row, column, range);
        free_range = RangeOfCell(d, image, slopes, range, row, i);
        lean = StorePlane(d, rotation, 0.5f * options.resolution_m, slopes, range, i, out.surface);
      }
      if (options.reach_behind_m > 0.0f) hn::StoreU(lean.inverse_cos, d, out.surface->inverse_cos.data() + i);
      StoreMargins(d, options, lean, free_range, hit, row, column, i, out.margins);
    });
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace atlas::mapping
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace atlas::mapping {
namespace {
HWY_EXPORT(PlanesOfRows);
}  // namespace

void FindPlanes(const core::Mat3& rotation_map_lidar, const ImageOptions& options, const RangeImage& image,
                const PlanesOut& out) {
  out.surface->image = out.margins->image = &image;
  float rotation[9];
  for (int i = 0; i < 9; ++i) rotation[i] = static_cast<float>(rotation_map_lidar(i / 3, i % 3));
  core::ParallelFor(options.threads, static_cast<size_t>(image.rows), [&](size_t begin, size_t end, size_t) {
    HWY_DYNAMIC_DISPATCH(PlanesOfRows)(rotation, options, begin, end, out);
  });
}

}  // namespace atlas::mapping
#endif
