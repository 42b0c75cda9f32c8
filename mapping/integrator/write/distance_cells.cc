// Distances of voxels to the surface planes of their nearest beams (MultiresTSDF).
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/integrator/write/distance_cells.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "mapping/integrator/free_space/block_project-inl.h"
#include "mapping/integrator/write/tsdf_apply.h"

HWY_BEFORE_NAMESPACE();
namespace atlas::mapping {
namespace HWY_NAMESPACE {

struct DistanceRules {
  float truncation_m, per_unit;
};

constexpr float kFrontShare = 1.5f;  ///< of the truncation over the cosine of incidence, in front of a return

HWY_INLINE bool StoreNone(DF, int16_t* out) {
  const hn::Rebind<int16_t, DF> d16;
  hn::StoreU(hn::Set(d16, kNoDistance), d16, out);
  return false;
}

/// Distances of Lanes(d) voxels at (x, y, z) in the turned frame; stores them; true where any is within
/// the truncation.
HWY_INLINE bool MeasureVector(DF d, const SurfaceImage& surface, const DistanceRules& rules,
                              const GridPoint& p, VF x, VF y, VF z, const float turn[2], int16_t* out) {
  const RangeImage& image = *surface.image;
  const DI di;
  const hn::Rebind<int16_t, DF> d16;
  const VF half = hn::Set(d, 0.5f), none = hn::Set(d, static_cast<float>(kNoDistance));
  const MF in =
      hn::And(hn::Ge(p.v, hn::Neg(half)), hn::Lt(p.v, hn::Set(d, static_cast<float>(image.rows) - 0.5f)));
  const VI columns = hn::Set(di, image.columns);
  const VI row = FloorPositive(di, hn::Add(hn::IfThenElseZero(in, p.v), half));
  VI column = FloorPositive(di, hn::Add(p.u, half));
  column = hn::IfThenElse(hn::Lt(column, columns), column, hn::Sub(column, columns));
  const VI cell = hn::Add(hn::Mul(row, columns), column);
  const VF range = hn::GatherIndex(d, image.range.data(), cell);
  const MF hit = hn::And(in, hn::Gt(range, hn::Zero(d)));
  if (hn::AllFalse(d, hit)) return StoreNone(d, out);
  const VF far = hn::Set(d, rules.truncation_m);
  // Behind the return the plane holds as far as the next beams' returns may lie: no farther, or the far side
  // of a thin or round thing would be taken for its inside. In front, no farther than a beam at that
  // incidence needs to come within the truncation.
  const VF grazing = hn::GatherIndex(d, surface.inverse_cos.data(), cell);
  const VF pitch = hn::Set(d, 0.5f * static_cast<float>(image.grid->mean_row_pitch_rad));
  const VF gap = hn::Mul(hn::Mul(range, pitch), grazing);
  const VF past = hn::Sub(p.distance, range);
  const MF reached = hn::And(
      hit,
      hn::And(hn::Lt(past, hn::Add(far, gap)),
              hn::Lt(hn::Neg(past), hn::Add(gap, hn::Mul(hn::Mul(far, hn::Set(d, kFrontShare)), grazing)))));
  if (hn::AllFalse(d, reached)) return StoreNone(d, out);
  const VF nx = hn::GatherIndex(d, surface.nx.data(), cell), ny = hn::GatherIndex(d, surface.ny.data(), cell),
           nz = hn::GatherIndex(d, surface.nz.data(), cell);
  const VF px = hn::GatherIndex(d, image.x.data(), cell), py = hn::GatherIndex(d, image.y.data(), cell),
           pz = hn::GatherIndex(d, image.z.data(), cell);
  // Back from the turned frame.
  const VF c = hn::Set(d, turn[0]), s = hn::Set(d, turn[1]);
  const VF lx = hn::Sub(hn::Mul(x, c), hn::Mul(y, s)), ly = hn::Add(hn::Mul(x, s), hn::Mul(y, c));
  const VF distance = hn::Add(hn::Add(hn::Mul(nx, hn::Sub(lx, px)), hn::Mul(ny, hn::Sub(ly, py))),
                              hn::Mul(nz, hn::Sub(z, pz)));
  const MF within = hn::And(reached, hn::Lt(hn::Abs(distance), far));
  const bool any = !hn::AllFalse(d, within);
  const VF value = hn::IfThenElse(within, hn::Mul(distance, hn::Set(d, rules.per_unit)), none);
  const VI rounded =
      hn::ConvertTo(di, hn::Add(value, hn::CopySign(hn::IfThenElseZero(hn::Ne(value, none), half), value)));
  hn::StoreU(hn::DemoteTo(d16, rounded), d16, out);
  return any;
}

/// Groups of 16 cells: `rows` of them a layer.
template <typename Projector>
HWY_INLINE bool MeasureLayers(const SurfaceImage& surface, const DistanceRules& rules, const Lattice& lattice,
                              int rows, int layers, const Projector& projector, int16_t* out) {
  const DF d;
  bool any = false;
  for (int layer = 0; layer < layers; ++layer) {
    for (int row = 0; row < rows; ++row, out += kGroup) {
      VF at[3];
      for (size_t i = 0; i < kGroup; i += hn::Lanes(d)) {
        for (int c = 0; c < 3; ++c) {
          const float base = lattice.first[c] + static_cast<float>(row) * lattice.step_y[c] +
                             static_cast<float>(layer) * lattice.step_z[c];
          at[c] = hn::Add(hn::Set(d, base), hn::Load(d, lattice.lane[c] + i));
        }
        const GridPoint p = projector.Project(d, at[0], at[1], at[2]);
        any |= MeasureVector(d, surface, rules, p, at[0], at[1], at[2], lattice.turn, out + i);
      }
    }
  }
  return any;
}

HWY_INLINE bool Measure(const SurfaceImage& surface, const ScanFrame& frame, const ScanFrame::Lanes& lanes,
                        const NodeKey& corner, int scale, const DistanceRules& rules, int16_t* out) {
  const Place place = PlaceOf(frame, corner, kBlockSide);
  const Lattice lattice = LatticeOf(frame, lanes, corner, scale, place.turn);
  const int rows = scale == 1 ? 4 : 1, layers = kBlockSide / scale;
  if (place.near) {
    return MeasureLayers(surface, rules, lattice, rows, layers, NearProjector{*surface.image->grid}, out);
  }
  FarProjector projector;
  SetProjector(*surface.image->grid, place, kBlockRadius * frame.resolution_m, &projector);
  return MeasureLayers(surface, rules, lattice, rows, layers, projector, out);
}

bool MeasureBlock(const SurfaceImage& surface, const ScanFrame& frame, const NodeKey& corner,
                  float truncation_m, float unit_m, int16_t* out) {
  return Measure(surface, frame, frame.lanes_1, corner, 1, {truncation_m, 1.0f / unit_m}, out);
}
bool MeasureBlockCells(const SurfaceImage& surface, const ScanFrame& frame, const NodeKey& corner,
                       float truncation_m, float unit_m, int16_t* out) {
  return Measure(surface, frame, frame.lanes_2, corner, 2, {truncation_m, 1.0f / unit_m}, out);
}

}  // namespace HWY_NAMESPACE
}  // namespace atlas::mapping
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace atlas::mapping {
namespace {
HWY_EXPORT(MeasureBlock);
HWY_EXPORT(MeasureBlockCells);
}  // namespace

bool MeasureDistances(const SurfaceImage& surface, const ScanFrame& frame, const NodeKey& corner,
                      float truncation_m, float unit_m, int16_t* out) {
  return HWY_DYNAMIC_DISPATCH(MeasureBlock)(surface, frame, corner, truncation_m, unit_m, out);
}

bool MeasureCellDistances(const SurfaceImage& surface, const ScanFrame& frame, const NodeKey& corner,
                          float truncation_m, float unit_m, int16_t* out) {
  return HWY_DYNAMIC_DISPATCH(MeasureBlockCells)(surface, frame, corner, truncation_m, unit_m, out);
}

}  // namespace atlas::mapping
#endif
