#include "mapping/terrain/cell_reading.h"

namespace atlas::mapping::terrain {
namespace {

/// A cell without ground: something in the way, a floor far below, or nothing.
Reading ReadOther(const WaveParams& params, const LayeredCell& cell, float reference) {
  Reading reading;
  for (const Layer& layer : cell.layer) {
    if (layer.count < kMinSupport) continue;
    const bool in_the_way =
        layer.hi_m > reference + params.link_m && layer.lo_m < reference + params.headroom_m;
    if (in_the_way && (reading.kind != CellKind::kObstacle || layer.hi_m < reading.height_m)) {
      reading = {CellKind::kObstacle, layer.hi_m, layer.count, true};
    } else if (reading.kind != CellKind::kObstacle && layer.hi_m < reference - params.link_m &&
               (reading.kind == CellKind::kUnseen || layer.mean_m > reading.height_m)) {
      reading = {CellKind::kBelow, layer.mean_m, 0, false};
    }
  }
  return reading;
}

}  // namespace

const Layer* FindSurface(const WaveParams& params, const LayeredCell& cell, float reference) {
  uint16_t strongest = 0;
  for (const Layer& layer : cell.layer) {
    if (layer.count > strongest && std::abs(SurfaceOf(layer) - reference) <= params.link_m)
      strongest = layer.count;
  }
  if (strongest == 0) return nullptr;
  const Layer* highest = nullptr;
  const Layer* nearest = nullptr;
  for (const Layer& layer : cell.layer) {
    const float above = SurfaceOf(layer) - reference;
    const bool single = layer.count == 1 && std::abs(above) <= kSingleReturnGate_m && strongest == 1;
    if (layer.count == 0 || std::abs(above) > params.link_m || (layer.count < kMinSupport && !single))
      continue;
    if (above <= params.step_m && layer.count * 4 >= strongest &&
        (highest == nullptr || SurfaceOf(layer) > SurfaceOf(*highest))) {
      highest = &layer;
    }
    if (nearest == nullptr || std::abs(above) < std::abs(SurfaceOf(*nearest) - reference)) nearest = &layer;
  }
  return highest != nullptr ? highest : nearest;
}

Reading ReadGround(const WaveParams& params, const LayeredCell& cell, const Layer& surface) {
  Reading reading{CellKind::kGround, SurfaceOf(surface), surface.count, false};
  const float low = reading.height_m + params.step_m, high = reading.height_m + params.headroom_m;
  for (const Layer& layer : cell.layer) {
    if (layer.count < kMinSupport || (&layer == &surface && !IsTall(layer))) continue;
    if (layer.hi_m > low && layer.lo_m < high) reading.blocked = true;
  }
  return reading;
}

Reading ReadCell(const WaveParams& params, const LayeredCell& cell, float reference) {
  if (const Layer* surface = FindSurface(params, cell, reference)) return ReadGround(params, cell, *surface);
  return ReadOther(params, cell, reference);
}

}  // namespace atlas::mapping::terrain
