// Eq. 4.2 in units of OccupancyField and voxels.
#pragma once

#include <algorithm>

#include "mapping/integrator/integrator.h"

namespace atlas::mapping {

struct SurfaceModel {
  float miss_units = 8.0f;        ///< -L_min
  int hit_units = 16;             ///< of the voxel that holds the return
  int near_units = 8;             ///< at most, of others that the surface reaches
  float sigma_min_voxels = 0.3f;  ///< sigma(d) = max(sigma_min, lambda_sigma d)
  float lambda_sigma = 0.0005f;
  float lambda_r = 0.02f;          ///< occupied depth behind the surface, a share of the range ...
  float behind_min_voxels = 1.5f;  ///< ... at least
  float behind_max_voxels = 5.0f;  ///< ... and at most
  float skim_cosine = 0.0f;        ///< hits at a lower cosine of incidence have no trail

  static SurfaceModel Of(const IntegratorParams& params, double resolution_m) {
    SurfaceModel m;
    m.miss_units = static_cast<float>(OccupancyField::StepsOf(params.miss_nats));
    m.hit_units = OccupancyField::StepsOf(params.hit_nats);
    m.near_units = std::min(OccupancyField::StepsOf(params.near_nats), m.hit_units - OccupancyField::kPlaces);
    m.sigma_min_voxels = static_cast<float>(params.sigma_min_m / resolution_m);
    m.lambda_sigma = static_cast<float>(params.lambda_sigma);
    m.lambda_r = static_cast<float>(params.lambda_r);
    m.behind_min_voxels = static_cast<float>(params.behind_min_voxels);
    m.behind_max_voxels =
        static_cast<float>(std::max(params.behind_max_m / resolution_m, params.behind_min_voxels));
    m.skim_cosine = static_cast<float>(params.skim_cosine);
    return m;
  }
};

}  // namespace atlas::mapping
