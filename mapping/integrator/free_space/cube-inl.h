// Cubes as the sensor sees them, and grid coordinates within them by first order, for each SIMD target.
#if defined(ATLAS_MAPPING_INTEGRATOR_CUBE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATLAS_MAPPING_INTEGRATOR_CUBE_INL_H_
#undef ATLAS_MAPPING_INTEGRATOR_CUBE_INL_H_
#else
#define ATLAS_MAPPING_INTEGRATOR_CUBE_INL_H_
#endif

#include "mapping/integrator/free_space/fill_kernels.h"
#include "mapping/integrator/projection/project-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atlas::mapping {
namespace HWY_NAMESPACE {

constexpr float kSqrt3 = 1.7320508f;
constexpr float kMinAxisDistanceRadii =
    2.5f;                            ///< nearer to the axis, the azimuth wraps and the footprint is undefined
constexpr float kFirstOrder = 0.1f;  ///< voxels: what the second order may add for first order to do
constexpr float kRowBend = 0.05f;    ///< rows: what uneven beams may
constexpr int kColumnsSpare = 4;     ///< kept from the seam of the grid, for windows around

/// A voxel along one map axis at a cube: metres across and outward (horizontally), up and along (in the
/// upright plane through the beam to its middle).
struct Axis {
  VF across, outward, up, along;
};

/// Lanes(d) cubes.
struct Cubes {
  VF x, y, z, flat, distance;  ///< of the middles, metres in the LiDAR frame
  VF sine, cosine;             ///< of their elevations
  Axis axis[3];
  VF across, outward, up, along;  ///< half of what a cube spans
};

/// @param wx, wy, wz  middles in window coordinates.
HWY_INLINE Cubes CubesAt(DF d, const ScanFrame& frame, VF wx, VF wy, VF wz, float half_side) {
  const VF dx = hn::Sub(wx, hn::Set(d, frame.sensor[0])), dy = hn::Sub(wy, hn::Set(d, frame.sensor[1])),
           dz = hn::Sub(wz, hn::Set(d, frame.sensor[2]));
  const auto component = [&](int c) {
    return hn::Add(
        hn::Add(hn::Mul(dx, hn::Set(d, frame.axis[0][c])), hn::Mul(dy, hn::Set(d, frame.axis[1][c]))),
        hn::Mul(dz, hn::Set(d, frame.axis[2][c])));
  };
  const VF one = hn::Set(d, 1.0f), least = hn::Set(d, 1e-6f);
  Cubes m;
  m.x = component(0);
  m.y = component(1);
  m.z = component(2);
  const VF flat2 = hn::Add(hn::Mul(m.x, m.x), hn::Mul(m.y, m.y));
  m.flat = hn::Max(hn::Sqrt(flat2), least);
  m.distance = hn::Max(hn::Sqrt(hn::Add(flat2, hn::Mul(m.z, m.z))), least);
  const VF inverse = hn::Div(one, m.distance), inverse_flat = hn::Div(one, m.flat);
  m.sine = hn::Mul(m.z, inverse);
  m.cosine = hn::Mul(m.flat, inverse);
  const VF cx = hn::Mul(m.x, inverse_flat), cy = hn::Mul(m.y, inverse_flat);
  m.across = m.outward = m.up = m.along = hn::Zero(d);
  for (int a = 0; a < 3; ++a) {
    const VF ax = hn::Set(d, frame.axis[a][0]), ay = hn::Set(d, frame.axis[a][1]),
             az = hn::Set(d, frame.axis[a][2]);
    Axis& axis = m.axis[a];
    axis.outward = hn::Add(hn::Mul(ax, cx), hn::Mul(ay, cy));
    axis.across = hn::Sub(hn::Mul(ay, cx), hn::Mul(ax, cy));
    axis.up = hn::Sub(hn::Mul(m.cosine, az), hn::Mul(m.sine, axis.outward));
    axis.along = hn::Add(hn::Mul(m.cosine, axis.outward), hn::Mul(m.sine, az));
    m.across = hn::Add(m.across, hn::Abs(axis.across));
    m.outward = hn::Add(m.outward, hn::Abs(axis.outward));
    m.up = hn::Add(m.up, hn::Abs(axis.up));
    m.along = hn::Add(m.along, hn::Abs(axis.along));
  }
  const VF half = hn::Set(d, half_side);
  m.across = hn::Mul(m.across, half);
  m.outward = hn::Mul(m.outward, half);
  m.up = hn::Mul(m.up, half);
  m.along = hn::Mul(m.along, half);
  return m;
}

/// Cells that cubes can touch: rows [v0, v1], columns [u0, u1] with u0 possibly a turn off.
struct Footprint {
  VF u, top, bottom, raised;  ///< column of the middle, rows and the sine of the angle up to the sides
  VI v0, v1, u0, u1;
  MF outside, clipped;
};

/// @pre the cubes are off the sensor's axis, by kMinAxisDistanceRadii; else the footprint is undefined.
HWY_INLINE Footprint FootprintOf(DF d, const BeamGrid& grid, const Cubes& m) {
  const DI di;
  const VF one = hn::Set(d, 1.0f), least = hn::Set(d, 1e-6f);
  // Tangents of the angles from the middle to the sides: of azimuth, then of elevation, where points beside
  // the middle's upright plane lie farther out than they seem.
  const VF inward = hn::Max(hn::Sub(m.flat, m.outward), least);
  const VF turned = hn::Div(m.across, inward);
  const VF bulge = hn::Mul(hn::Mul(hn::Mul(m.across, turned), hn::Set(d, 0.5f)), hn::Abs(m.sine));
  const VF raised = hn::Div(hn::Add(m.up, bulge), hn::Max(hn::Sub(m.distance, m.along), least));
  Footprint f;
  f.raised = hn::Min(raised, one);
  const VF ca = hn::Sqrt(hn::Sub(one, hn::Mul(f.raised, f.raised)));
  const VF a = hn::Mul(m.sine, ca), b = hn::Mul(m.cosine, f.raised);
  f.top = RowOf(d, grid, hn::Add(a, b));
  f.bottom = RowOf(d, grid, hn::Sub(a, b));
  const VF last = hn::Set(d, static_cast<float>(grid.rows - 1));
  const VF half = hn::Set(d, 0.5f);
  f.outside = hn::Or(hn::Lt(f.bottom, hn::Neg(half)), hn::Gt(f.top, hn::Add(last, half)));
  f.clipped = hn::Or(hn::Lt(f.top, hn::Zero(d)), hn::Gt(f.bottom, last));
  f.v0 = FloorPositive(di, hn::Min(hn::Max(f.top, hn::Zero(d)), last));
  f.v1 = hn::Min(FloorPositive(di, hn::Add(hn::Max(f.bottom, hn::Zero(d)), one)), hn::Set(di, grid.rows - 1));
  f.u = ColumnOf(d, grid, m.x, m.y);
  const VF turn = hn::Set(d, static_cast<float>(grid.columns));
  const VF reach =
      hn::Min(hn::Mul(turned, hn::Set(d, static_cast<float>(1.0 / grid.column_pitch_rad))), turn);
  f.u0 = hn::Sub(FloorPositive(di, hn::Add(hn::Max(hn::Sub(f.u, reach), hn::Neg(turn)), turn)),
                 hn::Set(di, grid.columns));
  f.u1 = FloorPositive(di, hn::Add(hn::Min(hn::Add(f.u, reach), hn::Add(turn, turn)), one));
  return f;
}

/// Grid coordinates within the cubes by first order, for 4^3 cells of a quarter of their side. Returns where
/// that is good to kFirstOrder and kRowBend: away from the axis and the seam, not wholly outside the rows.
HWY_INLINE MF StoreSlopes(DF d, const ScanFrame& frame, const BeamGrid& grid, const Cubes& m,
                          const Footprint& f, float half_side, size_t lane, CubeSlopes* out) {
  const DI di;
  const VF row = RowOf(d, grid, m.sine);
  const VF bend = hn::Abs(hn::Sub(hn::Add(row, row), hn::Add(f.top, f.bottom)));
  const float radius = (half_side - 0.5f) * kSqrt3;
  const VF nearest = hn::Set(d, radius * radius / (2.0f * kFirstOrder) * frame.resolution_m);
  const VF per_u = hn::Mul(m.flat, hn::Set(d, static_cast<float>(grid.column_pitch_rad)));
  const VF per_v = hn::Div(hn::Mul(hn::Mul(f.raised, m.distance), hn::Set(d, 2.0f)),
                           hn::Max(hn::Sub(f.bottom, f.top), hn::Set(d, 1e-6f)));
  const VF one = hn::Set(d, 1.0f);
  const VF columns_per_m = hn::Div(one, per_u), rows_per_m = hn::Neg(hn::Div(one, per_v));
  hn::Store(f.u, d, out->u + lane);
  hn::Store(row, d, out->v + lane);
  hn::Store(m.distance, d, out->distance + lane);
  hn::Store(per_u, d, out->metres_per_column + lane);
  hn::Store(per_v, d, out->metres_per_row + lane);
  // The cells' middles reach three quarters out; a little more for rounding.
  const VF reach = hn::Set(d, 0.75f), slack = hn::Set(d, 0.01f);
  const VF beside = hn::Add(hn::Mul(hn::Mul(m.across, columns_per_m), reach), slack);
  const VF above = hn::Sub(slack, hn::Mul(hn::Mul(m.up, rows_per_m), reach));
  const VF column = hn::Floor(hn::Sub(f.u, beside));
  const VF first_row = hn::Max(hn::Floor(hn::Sub(row, above)), hn::Set(d, -1.0f));
  const VF last_column = hn::Sub(hn::Add(f.u, beside), column);
  const VF last_row = hn::Sub(hn::Add(row, above), first_row);
  VI window = hn::Set(di, CubeSlopes::kWindows);
  for (int i = CubeSlopes::kWindows - 1; i >= 0; --i) {
    const MF fits = hn::And(hn::Lt(last_column, hn::Set(d, static_cast<float>(CubeSlopes::kColumns[i] - 1))),
                            hn::Lt(last_row, hn::Set(d, static_cast<float>(CubeSlopes::kRows[i] - 1))));
    window = hn::IfThenElse(hn::RebindMask(di, fits), hn::Set(di, i), window);
  }
  hn::Store(hn::ConvertTo(di, column), di, out->first_column + lane);
  hn::Store(hn::ConvertTo(di, first_row), di, out->first_row + lane);
  hn::Store(window, di, out->window + lane);
  for (size_t a = 0; a < 3; ++a) {
    hn::Store(hn::Mul(m.axis[a].across, columns_per_m), d, out->du[a] + lane);
    hn::Store(hn::Mul(m.axis[a].up, rows_per_m), d, out->dv[a] + lane);
    hn::Store(m.axis[a].along, d, out->ddistance[a] + lane);
  }
  const VF rows_per_voxel = hn::Mul(hn::Neg(rows_per_m), hn::Set(d, frame.resolution_m));
  const VF bends = hn::Max(hn::Set(d, kRowBend), hn::Mul(rows_per_voxel, hn::Set(d, kFirstOrder)));
  const MF far = hn::And(hn::Ge(m.flat, nearest), hn::Le(bend, hn::Add(bends, bends)));
  const MF seamless = hn::And(hn::RebindMask(d, hn::Gt(f.u0, hn::Set(di, kColumnsSpare - 1))),
                              hn::RebindMask(d, hn::Lt(f.u1, hn::Set(di, grid.columns))));
  return hn::AndNot(f.outside, hn::And(far, seamless));
}

}  // namespace HWY_NAMESPACE
}  // namespace atlas::mapping
HWY_AFTER_NAMESPACE();

#endif
