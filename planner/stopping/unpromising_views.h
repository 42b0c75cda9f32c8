// Which view to take where no view promises anything.
#pragma once

#include <vector>

#include "planner/decision.h"

namespace atlas::planner {

/// The view whose place differs most from those of all scans. @pre candidates are not empty.
int FarthestFromScans(const std::vector<Candidate>& candidates, const std::vector<core::Vec2>& scans);

/// From the object to the nearest of `places`; infinite where there is none.
double DistanceToObject(const std::vector<core::Vec2>& places, const core::Box3& object_box);

/// Of an object farther than `range_m` from all scans, so that no view of it can be predicted: the view that
/// is nearest to it, where that is nearer than all scans; else -1.
int NearestToObject(const std::vector<Candidate>& candidates, const std::vector<core::Vec2>& scans,
                    const core::Box3& object_box, double range_m);

}  // namespace atlas::planner
