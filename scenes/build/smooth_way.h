// A smooth curve through given points: paths in parks, routes of sensors.
#pragma once

#include <vector>

#include "core/geometry.h"

namespace atlas::scenes {

/// Points every `spacing_m` or less along the centripetal Catmull-Rom curve through `way`, its ends included;
/// where first and last are equal the curve closes smoothly. @pre at least two points, consecutive ones
/// apart.
std::vector<core::Vec3> SmoothWay(const std::vector<core::Vec3>& way, double spacing_m);

}  // namespace atlas::scenes
