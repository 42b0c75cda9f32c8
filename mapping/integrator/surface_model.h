// Eq. 4.2 in units of OccupancyField and voxels.
#pragma once

#include <algorithm>
#include <cmath>

#include "mapping/integrator/integrator.h"

namespace atlas::mapping {

struct SurfaceModel {
  float miss_units = 8.0f;        ///< -L_min
  int hit_units = 17;             ///< least of the voxel that holds the return
  float sigma_min_voxels = 0.3f;  ///< sigma(d) = max(sigma_min, lambda_sigma d)
  float lambda_sigma = 0.0005f;
  float lambda_r = 0.02f;          ///< occupied depth behind the surface, a share of the range ...
  float behind_min_voxels = 1.5f;  ///< ... at least
  float behind_max_voxels = 5.0f;  ///< ... and at most

  static SurfaceModel Of(const IntegratorParams& params, double resolution_m) {
    SurfaceModel m;
    m.miss_units = static_cast<float>(params.miss_nats / OccupancyField::kNatsPerUnit);
    m.hit_units = static_cast<int>(std::lround(params.hit_nats / OccupancyField::kNatsPerUnit));
    m.sigma_min_voxels = static_cast<float>(params.sigma_min_m / resolution_m);
    m.lambda_sigma = static_cast<float>(params.lambda_sigma);
    m.lambda_r = static_cast<float>(params.lambda_r);
    m.behind_min_voxels = static_cast<float>(params.behind_min_voxels);
    m.behind_max_voxels =
        static_cast<float>(std::max(params.behind_max_m / resolution_m, params.behind_min_voxels));
    return m;
  }

  /// 3 sigma(d): farther in front all is as free as can be.
  float Band(float range_voxels) const {
    return 3.0f * std::max(sigma_min_voxels, lambda_sigma * range_voxels);
  }
  /// lambda_r d: farther behind nothing is known.
  float Depth(float range_voxels) const {
    return std::clamp(lambda_r * range_voxels, behind_min_voxels, behind_max_voxels);
  }
  /// Log-odds of a voxel at this signed distance behind the (shifted) surface, negative in front.
  /// @pre distance_voxels <= Depth(range_voxels).
  float LogOdds(float distance_voxels, float range_voxels) const {
    const float band = Band(range_voxels);
    if (distance_voxels <= -band) return -miss_units;
    return miss_units / band * std::min(distance_voxels, 0.5f * Depth(range_voxels));
  }
};

}  // namespace atlas::mapping
