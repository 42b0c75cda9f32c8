// When revolutions go to a submap, to an older one or to a new one, and when two submaps become one.
#pragma once

#include <string>

#include "core/params.h"

namespace atlas::mapping {

struct AtlasParams {
  std::string field = "occupancy";  ///< of submaps: occupancy | tsdf
  double lambda_odom_m = 30.0;      ///< thesis 4.7.1: a submap takes keyframes up to this far along the graph
  double cloud_overlap = 0.6;       ///< thesis 4.7.3: and while this share of their returns is near its cloud
  double cloud_filter_m = 0.1;      ///< r_filter of Algorithm 1
  double doorway_m = 2.0;  ///< widest opening that ends a submap where the sensor passes it; 0: none does
  double level_m = 0.0;    ///< between the heights of what a submap holds and its root; 0: any
  bool reentry = true;     ///< an older submap that a keyframe fits is taken up again
  double reentry_overlap = 0.7;       ///< where this share of the keyframe's returns is near its cloud
  double fusion_overlap = 0.7;        ///< thesis 4.8.2, lambda_fusion, of either volume
  double fusion_overlap_both = 0.35;  ///< and of both volumes
  double fusion_range_m = 0.0;        ///< between the nearest keyframes of two submaps that may become one
  double lambda_cluster_m = 0.0;      ///< thesis 4.7.1, 4.8.1: along the graph from the ends of a loop
  double sigma_max_m = 0.2;           ///< thesis 4.9, lambda_uncertainty
  double update_m = 0.1;              ///< thesis 4.7.4, Eq. 4.5
  double update_deg = 2.5;
  double memory_limit_mb = 0.0;  ///< of octrees in memory; 0: none
  void Visit(core::ParamVisitor& v);
};

}  // namespace atlas::mapping
