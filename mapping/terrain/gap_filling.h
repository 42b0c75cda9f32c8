// Which cells bear weight: gratings are closed, small gaps interpolated, holes kept.
#pragma once

#include <cstdint>
#include <vector>

#include "mapping/terrain/grid_filters.h"
#include "mapping/terrain/ground_wave.h"

namespace atlas::mapping::terrain {

struct Support {
  std::vector<float> height_m;  ///< smoothed where solid; what was seen elsewhere; NaN where nothing
  std::vector<float> low_m;     ///< the same, but gaps are as low as the lowest ground at their rim
  Mask solid;                   ///< measured or filled
  Mask open;                    ///< no support and no obstacle: hole, drop or unknown
  Mask filled;                  ///< solid by interpolation or between bars
};

/// A gap stays open where a disc of diameter `max_fill_m` fits into it without touching ground. Where rays
/// were seen to go down through it, a disc of half that is enough: a grating has bars nearer to each other.
Support FindSupport(double cell_m, double max_fill_m, const GroundImage& ground);

}  // namespace atlas::mapping::terrain
