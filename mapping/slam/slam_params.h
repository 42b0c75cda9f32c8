// `localisation.name: slam`: when nodes are made, how sure edges are, what closes a loop and when it takes
// effect.
#pragma once

#include "core/params.h"

namespace atlas::mapping {

struct SlamParams {
  double node_spacing_m = 2.0;  ///< thesis 4.10.1
  // Of odometry's error after 2 m, an axis, which grows with the root of the way.
  double odometry_sigma_m = 0.02;
  double odometry_sigma_deg = 0.1;
  double loop_radius_m = 5.0;    ///< nodes this near are looked at for a loop
  double loop_min_way_m = 12.0;  ///< but not those that odometry has just come from
  double loop_overlap = 0.6;     ///< of a loop's clouds, at least
  double loop_gate_sigmas = 3.0;
  int loop_tries = 2;           ///< registrations a node, at most, of either kind of candidate
  double place_distance = 0.5;  ///< of plans that may be one place (PlaceCandidate::distance)
  double latency_s = 0.3;       ///< simulated: from a node's end until its loops take effect
  double full_latency_s = 3.0;  ///< likewise of the full robust pass that follows accepted loops
  void Visit(core::ParamVisitor& v);
};

}  // namespace atlas::mapping
