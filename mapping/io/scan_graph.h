// OctoMap scan graphs: a log of clouds with the pose each was taken from.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "mapping/io/recorded_cloud.h"

namespace atlas::mapping {

/// The table of contents of a graph: binary (.graph: octomap::ScanGraph::writeBinary, little endian) or text
/// (rows "NODE x y z roll pitch yaw", each followed by its points, one "x y z" a row).
struct ScanGraphIndex {
  struct Node {
    core::Pose T_map_lidar = core::Pose::Identity();
    size_t points = 0;
    size_t first_byte = 0;  ///< of the points
    size_t bytes = 0;
  };
  std::vector<Node> nodes;
  bool binary = true;
};

/// @throws InputError "FILE: reason": counts that the file cannot hold, a pose that is none, data left over.
ScanGraphIndex IndexScanGraph(std::string_view bytes, const std::string& file);
/// The points of one node. @throws InputError.
RecordedCloud ReadScanOfGraph(std::string_view bytes, const ScanGraphIndex& index, size_t node,
                              const std::string& file);

}  // namespace atlas::mapping
