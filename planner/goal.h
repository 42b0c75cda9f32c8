// What is to be mapped: where to look is the goal's, not the map's.
#pragma once

#include <variant>

#include "core/geometry.h"

namespace atlas::planner {

/// The object that stands in a box of the map.
struct ObjectInBox {
  core::Box3 box_map;
};

/// All that can be reached within these bounds.
struct WholeSpace {
  core::Box3 bounds_map;
};

using Goal = std::variant<ObjectInBox, WholeSpace>;

/// What views are predicted of.
inline const core::Box3& BoxOf(const Goal& goal) {
  const auto* object = std::get_if<ObjectInBox>(&goal);
  return object != nullptr ? object->box_map : std::get<WholeSpace>(goal).bounds_map;
}

}  // namespace atlas::planner
