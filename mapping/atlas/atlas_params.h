// When revolutions go to a submap, and when to a new one.
#pragma once

#include "core/params.h"

namespace atlas::mapping {

struct AtlasParams {
  double lambda_odom_m = 30.0;  ///< thesis 4.7.1: a submap takes keyframes up to this far along the graph
  double cloud_overlap = 0.6;   ///< thesis 4.7.3: and while this share of their returns is near its cloud
  double cloud_filter_m = 0.1;  ///< r_filter of Algorithm 1
  void Visit(core::ParamVisitor& v);
};

}  // namespace atlas::mapping
