// The bump that the area factor gain scores a share with.
#pragma once

namespace atlas::planner {

/// f(x; a) of Vasquez-Gomez 2014: smooth on [0, 1], f(0) = f(1) = 0, f(a) = 1.
/// @pre 0 < a < 1, 0 <= x <= 1.
double AreaFactorShape(double x, double a);

}  // namespace atlas::planner
