// What a cell holds where ground is expected at some height.
#pragma once

#include <cmath>
#include <limits>

#include "mapping/terrain/ground_wave.h"

namespace atlas::mapping::terrain {

constexpr uint16_t kMinSupport = 2;           ///< a single return may be noise ...
constexpr float kSingleReturnGate_m = 0.06f;  ///< ... unless it lies where ground is expected

inline bool IsTall(const Layer& layer) {
  return layer.hi_m - layer.lo_m > kTall_m;
}
inline float SurfaceOf(const Layer& layer) {
  return IsTall(layer) ? layer.lo_m : layer.mean_m;
}

struct Reading {
  CellKind kind = CellKind::kUnseen;
  float height_m = std::numeric_limits<float>::quiet_NaN();
  uint16_t support = 0;
  bool blocked = false;
};

/// The highest well supported surface up to a step above `reference`; else the nearest within the link; else
/// null.
const Layer* FindSurface(const WaveParams& params, const LayeredCell& cell, float reference);

/// Of a cell whose ground is `surface`.
Reading ReadGround(const WaveParams& params, const LayeredCell& cell, const Layer& surface);

/// Ground where there is some; else something in the way, a floor far below, or nothing.
Reading ReadCell(const WaveParams& params, const LayeredCell& cell, float reference);

}  // namespace atlas::mapping::terrain
