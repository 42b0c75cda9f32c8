// What is made of a finished map: a picture of its submaps, and the way planned on it.
#pragma once

#include "experiments/mission/mission.h"

namespace atlas::experiments {

/// submaps.png of a map of many submaps; planned_way.csv and planned_way.png where mission.plan_after asks
/// for a way. Without ffmpeg the pictures are left out and log.txt says so. @pre nothing of the mission runs.
void FinishWithPictures(Mission* mission);

/// The two places of mission.plan_after, or nothing where it is empty. @throws InputError for anything else.
std::optional<std::pair<core::Vec3, core::Vec3>> PlanAfterOf(const MissionParams& params);

}  // namespace atlas::experiments
