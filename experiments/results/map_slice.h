// A map at one height, as the picture that Nav2's map server reads.
#pragma once

#include <filesystem>

#include "core/geometry.h"
#include "mapping/map_view.h"

namespace atlas::experiments {

inline constexpr const char *kMapSliceImage = "map_slice.pgm", *kMapSliceLegend = "map_slice.yaml";

/// Writes map_slice.pgm (254 free, 0 occupied, 205 unknown; row 0 is the greatest y) and map_slice.yaml: a
/// pixel for each voxel's width of `box_map`, asked for at its middle and at `height_m`.
/// @throws InputError when a file cannot be written. @pre the box is finite and not empty.
void WriteMapSlice(const std::filesystem::path& folder, const mapping::MapView& map,
                   const core::Box3& box_map, double height_m);

}  // namespace atlas::experiments
