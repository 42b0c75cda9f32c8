// `localisation.name: slam`: when nodes are made, how sure edges are, and what closes a loop.
#pragma once

#include "core/params.h"

namespace atlas::mapping {

struct SlamParams {
  double node_spacing_m = 2.0;  ///< thesis 4.10.1
  // Of odometry's error after 2 m, an axis, which grows with the root of the way.
  double odometry_sigma_m = 0.02;
  double odometry_sigma_deg = 0.1;
  // Of a registration's error, an axis.
  double loop_sigma_m = 0.02;
  double loop_sigma_deg = 0.15;
  double loop_radius_m = 5.0;    ///< nodes this near are looked at for a loop
  double loop_min_way_m = 12.0;  ///< but not those that odometry has just come from
  double loop_overlap = 0.6;     ///< of a loop's clouds, at least
  int loop_tries = 2;            ///< registrations a node, at most
  void Visit(core::ParamVisitor& v);
};

}  // namespace atlas::mapping
