#include "mapping/integrator/integrator.h"

namespace atlas::mapping {

void VisitResolution(double* resolution_m, core::ParamVisitor& v) {
  v.Field("resolution_m", resolution_m,
          {.unit = "m", .min = 0.005, .max = 2.0, .doc = "edge of the smallest voxel"});
}

void IntegratorParams::VisitRays(core::ParamVisitor& v) {
  v.Field("max_range_m", &max_range_m,
          {.unit = "m", .min = 0.5, .max = 500.0, .doc = "longer returns are misses up to here"});
  v.Field("void_rays", &void_rays,
          {.choices = {"clear", "ignore"}, .doc = "clear: free to void_range_m; ignore: no evidence"});
  v.Field("void_range_m", &void_range_m,
          {.unit = "m", .min = 0.0, .max = 500.0, .doc = "a void ray is trusted this far"});
}

void IntegratorParams::VisitFilling(core::ParamVisitor& v) {
  v.Field("sigma_min_m", &sigma_min_m,
          {.unit = "m", .min = 0.001, .max = 1.0, .doc = "least range deviation (Eq. 4.2)"});
  v.Field("lambda_sigma", &lambda_sigma,
          {.min = 0.0, .max = 0.1, .doc = "range deviation a metre of range (Eq. 4.2)"});
  v.Field("pierce_voxels", &pierce_voxels,
          {.unit = "voxels",
           .min = 0.0,
           .max = 0.87,
           .doc = "a beam clears voxels whose middle it passes this near, though others end before them"});
  v.Field(
      "max_scale", &max_scale,
      {.unit = "voxels", .min = 1, .max = 4, .doc = "largest cell side inside a block: 1, 2 or 4 (3 is 2)"});
  v.Field("lossless", &lossless,
          {.doc = "collapse only equal voxels; else free leaves keep their least free value"});
  v.Field("motion_aware", &motion_aware, {.doc = "per-ray poses (thesis 4.5.3); off: one pose a scan"});
  v.Field("remap_stop_rad", &remap_stop_rad,
          {.unit = "rad", .min = 0.0, .max = 0.1, .doc = "the search for the nearest ray ends here"});
}

void IntegratorParams::VisitOccupancy(core::ParamVisitor& v) {
  v.Field(
      "lambda_r", &lambda_r,
      {.min = 0.0,
       .max = 1.0,
       .doc = "occupied depth behind the surface a metre of range (Eq. 4.2), between the two bounds below"});
  v.Field("behind_min_voxels", &behind_min_voxels,
          {.unit = "voxels",
           .min = 0.5,
           .max = 8.0,
           .doc = "occupied depth behind the surface is at least this"});
  v.Field("behind_max_m", &behind_max_m,
          {.unit = "m",
           .min = 0.0,
           .max = 5.0,
           .doc = "and at most this, so that walls stay thin; below the least it is the least"});
  v.Field("miss_nats", &miss_nats,
          {.unit = "nats",
           .min = 0.2,
           .max = 2.0,
           .doc = "evidence of one scan that a voxel is free, -L_min; in steps of 0.2 as those below"});
  v.Field("hit_nats", &hit_nats,
          {.unit = "nats",
           .min = 0.4,
           .max = 3.0,
           .doc = "evidence of one scan for the voxel that holds a return"});
  v.Field("edge_nats", &edge_nats,
          {.unit = "nats",
           .min = 0.2,
           .max = 2.0,
           .doc = "evidence of one scan against an occupied voxel that is free at a surface's edge"});
  v.Field("near_nats", &near_nats,
          {.unit = "nats",
           .min = 0.2,
           .max = 3.0,
           .doc = "most evidence of one scan for other voxels that the surface reaches; less than hit_nats"});
  v.Field(
      "skim_cosine", &skim_cosine,
      {.min = 0.0,
       .max = 1.0,
       .doc =
           "beams at a lower cosine of incidence update the voxels of their returns alone, and other beams "
           "that return from those voxels do no more; 0: none, from 0.5 on no beam updates what it passes "
           "over. Of organised occupancy scans only"});
}

void IntegratorParams::VisitTsdf(core::ParamVisitor& v) {
  v.Field("truncation_voxels", &truncation_voxels,
          {.unit = "voxels", .min = 1.5, .max = 6.0, .doc = "TSDF truncation at the finest scale"});
}

}  // namespace atlas::mapping
