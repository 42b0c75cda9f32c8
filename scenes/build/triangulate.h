// Polygons to triangles.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/geometry.h"

namespace atlas::scenes {

/// Ear clipping of a simple counter-clockwise polygon; triangles are counter-clockwise indices into
/// `polygon`. O(n^2) to O(n^3): meant for outlines of tens of corners.
std::vector<std::array<uint32_t, 3>> TriangulatePolygon(const std::vector<core::Vec2>& polygon);

/// Twice the signed area of triangle a b c: positive where counter-clockwise.
inline double Cross(const core::Vec2& a, const core::Vec2& b, const core::Vec2& c) {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

}  // namespace atlas::scenes
