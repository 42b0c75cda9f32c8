// The kinds of locomotion, one .cc each.
#pragma once

#include "sim/locomotion/locomotion.h"

namespace atlas::sim {

std::unique_ptr<Locomotion> MakeTrot(const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                                     const SimParams& params, const core::Rng& rng);
std::unique_ptr<Locomotion> MakeKinematic(const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                                          const SimParams& params, const core::Rng& rng);

std::unique_ptr<Locomotion> MakeCarried(const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                                        const SimParams& params, const core::Rng& rng);

}  // namespace atlas::sim
