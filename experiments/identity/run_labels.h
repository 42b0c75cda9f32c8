// What summary and tables say of a run's parameters, in words.
#pragma once

#include <string>

#include "experiments/identity/experiment_config.h"

namespace atlas::experiments {

/// "truth, 5 mm 0.05 deg, 1 s": kind of localisation, its noise (standard deviation of each axis), period.
std::string LocalisationLabel(const mapping::LocalisationParams& localisation);

/// "random walk, 3 mm 0.02 deg after 1 m; height, roll and pitch true": drift of position (of each axis) and
/// heading as standard deviations; it grows with the root of the distance.
std::string OdometryLabel(const sim::OdometryParams& odometry);

/// What feet are set on: "perceived" or "truth"; locomotion without physics always stands on true ground.
std::string TerrainLabel(const sim::LocomotionParams& locomotion);

/// What a view is worth to the planner where the gain alone does not say it: "surface_frontier x ... (30 %)".

}  // namespace atlas::experiments
