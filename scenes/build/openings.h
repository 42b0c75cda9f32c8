// Rectangles with rectangular holes: decks with stairwells, walls with windows.
#pragma once

#include <vector>

#include "core/geometry.h"

namespace atlas::scenes {

struct Rect {
  core::Vec2 min = core::Vec2::Zero(), max = core::Vec2::Zero();
};

/// Disjoint rectangles that cover `outer` less `holes`: columns between the holes' sides, merged where they
/// are alike. @pre holes lie inside `outer` and do not overlap.
std::vector<Rect> CoverAround(const Rect& outer, const std::vector<Rect>& holes);

}  // namespace atlas::scenes
