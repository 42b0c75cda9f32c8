// Localisers by name, for catalog.inc.
#pragma once

#include "mapping/slam/localiser.h"

namespace atlas::mapping {

/// `localisation.name: truth`. Each fix of T_map_base begins a keyframe, which holds what is seen until the
/// next. A robot that scans stands: all revolutions of a scanning action belong to the keyframe that it began
/// in.
std::unique_ptr<Localiser> BuildTruthLocaliser(const LocalisationParams& params, const LocaliserStart& start,
                                               const core::Rng& rng);

/// `localisation.name: none`. One keyframe: where the odometry began.
std::unique_ptr<Localiser> BuildNoLocaliser(const LocalisationParams& params, const LocaliserStart& start,
                                            const core::Rng& rng);

}  // namespace atlas::mapping
