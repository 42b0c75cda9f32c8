// What SLAM remembers, on disk: a folder beside the submaps of an atlas, from which a later session goes on.
//
//     graph.g2o        the pose graph, without false loops; ids are keyframes
//     nodes.csv        a keyframe a row: size of a voxel of its cloud, its sensor's pose on it
//     node_00012.ply   what was seen from it, in its sensor's frame, a point a voxel
//     view_00012.pgm   the nearest, and below it the farthest, that was seen in each direction (5 mm)
//     plan_00012.pbm   where something upright stood, from above: its looks as a place
//     files.csv        size and CRC-64 of each of these, written last
#pragma once

#include <filesystem>

#include "mapping/slam/slam_memory.h"

namespace atlas::mapping {

/// Where an atlas that was saved in `atlas_folder` keeps it.
std::filesystem::path SlamFolderOf(const std::filesystem::path& atlas_folder);

/// @throws InputError when a file cannot be written.
void WriteSlamMemory(const std::filesystem::path& folder, const SlamMemory& memory);
/// @throws InputError (one line: file, field, value, limit) where a file is missing, damaged or does not fit
/// the others.
SlamMemory LoadSlamMemory(const std::filesystem::path& folder);

}  // namespace atlas::mapping
