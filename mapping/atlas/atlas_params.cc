#include "mapping/atlas/atlas_params.h"

namespace atlas::mapping {
namespace {

void VisitFusion(AtlasParams* p, core::ParamVisitor& v) {
  v.Field("fusion_overlap", &p->fusion_overlap,
          {.min = 0.0,
           .max = 1.0,
           .doc = "submaps become one where either measured the like of this share of its volume (thesis "
                  "4.8.2, Alg. 2); 0: never"});
  v.Field("fusion_overlap_both", &p->fusion_overlap_both,
          {.min = 0.0,
           .max = 1.0,
           .doc = "and both at least of this share, so that a room does not swallow its closet; 0: as the "
                  "thesis"});
  v.Field("fusion_range_m", &p->fusion_range_m,
          {.unit = "m",
           .min = 0.0,
           .max = 1e4,
           .doc = "search range of submap overlap: between the nearest keyframes of the two; 0: any (thesis "
                  "4.8.2: between the ends of the loop)"});
  v.Field("lambda_cluster_m", &p->lambda_cluster_m,
          {.unit = "m",
           .min = 0.0,
           .max = 1e3,
           .doc = "submaps with keyframes this near along the graph to the ends of a loop become one (thesis "
                  "4.7.1, 4.8.1); 0: never"});
}

}  // namespace

void AtlasParams::Visit(core::ParamVisitor& v) {
  v.Field(
      "field", &field,
      {.choices = {"occupancy", "tsdf"},
       .doc = "what submaps hold (thesis 4.5): log-odds, or signed distances, whose sign tells what is free "
              "where they have weight"});
  v.Field("lambda_odom_m", &lambda_odom_m,
          {.unit = "m",
           .min = 1.0,
           .max = 1e6,
           .doc = "a submap ends this far along the keyframes from its root (thesis 4.7.1)"});
  v.Field("cloud_overlap", &cloud_overlap,
          {.min = 0.0,
           .max = 1.0,
           .doc = "a submap ends where less of a keyframe's cloud overlaps its own (thesis 4.7.3); 0: off"});
  v.Field("cloud_filter_m", &cloud_filter_m,
          {.unit = "m", .min = 0.02, .max = 2.0, .doc = "r_filter of cloud overlap (thesis Alg. 1)"});
  v.Field(
      "doorway_m", &doorway_m,
      {.unit = "m",
       .min = 0.0,
       .max = 10.0,
       .doc = "a submap ends where the sensor passes a doorway up to this wide: uprights on both sides of "
              "its way, along at most 2 m of it; what lies on either side then becomes one only where "
              "both measured fusion_overlap; 0: off (thesis)"});
  v.Field("level_m", &level_m,
          {.unit = "m",
           .min = 0.0,
           .max = 100.0,
           .doc = "a submap holds no keyframe, and becomes one with no submap, whose height differs from its "
                  "root's by more: half a storey keeps storeys apart; 0: any (thesis)"});
  v.Field("reentry", &reentry,
          {.doc = "a keyframe that the submap in use does not fit, or beyond a doorway, goes to the submap "
                  "that its cloud overlaps most, where that is reentry_overlap and sigma_max_m allows it; "
                  "false: to a new one (thesis)"});
  v.Field("reentry_overlap", &reentry_overlap,
          {.min = 0.0, .max = 1.0, .doc = "share of its cloud that takes a keyframe to an older submap"});
  VisitFusion(this, v);
  v.Field("sigma_max_m", &sigma_max_m,
          {.unit = "m",
           .min = 0.0,
           .max = 1e3,
           .doc = "greatest standard deviation of the way between what becomes one: of two roots, of a root "
                  "and a keyframe (thesis 4.9, Eq. 4.13); what is refused is tried again after corrections; "
                  "0: no bound"});
  v.Field("update_m", &update_m,
          {.unit = "m",
           .min = 0.0,
           .max = 10.0,
           .doc = "overlap is measured anew where submaps moved this far to each other (thesis 4.7.4)"});
  v.Field("update_deg", &update_deg,
          {.unit = "deg", .min = 0.0, .max = 180.0, .doc = "or turned so far (thesis 4.7.4)"});
  v.Field("memory_limit_mb", &memory_limit_mb,
          {.unit = "MB",
           .min = 0.0,
           .max = 1e7,
           .doc = "submaps that were used longest ago wait in files of the system's temporary folder while "
                  "octrees in memory are more than this; 0: no limit"});
}

}  // namespace atlas::mapping
