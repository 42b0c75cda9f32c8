// One function a gain, each defined in the gain's own file.
#pragma once

#include "planner/gain/gain.h"

namespace atlas::planner {

#define ATLAS_GAIN(Name) GainEntry Name##Gain();
#include "planner/gain/catalog.inc"
#undef ATLAS_GAIN

template <typename G>
std::unique_ptr<Gain> BuildGain(double resolution_m) {
  return std::make_unique<G>(resolution_m);
}

}  // namespace atlas::planner
