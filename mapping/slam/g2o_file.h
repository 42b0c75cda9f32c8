// Pose graphs as g2o files: the tags VERTEX_SE2, EDGE_SE2, VERTEX_SE3:QUAT, EDGE_SE3:QUAT and FIX.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "mapping/slam/pose_graph.h"

namespace atlas::mapping {

struct G2oGraph {
  PoseGraph graph;  ///< nodes in the order of their ids; poses by chordal initialisation if !has_poses
  std::vector<int64_t> id;    ///< of each node
  bool has_poses = true;      ///< whether the file has vertices; else all nodes are those that edges name
  size_t skipped = 0;         ///< lines with other tags
  std::string first_skipped;  ///< the tag of the first of them
  size_t without_cross_terms = 0;  ///< edges that lost those of translation and rotation, see ReadG2o
};

/// Reads a graph. Edges between consecutive ids are odometry, all others loops; but of the loops those, in
/// the order of the file, that connect pieces which nothing else has yet connected count as odometry.
/// Information is the upper triangle, row by row, or the whole matrix. A file that has vertices must have all
/// that its edges name; one without any gets its poses from its edges. Where the information's blocks of
/// translation and of rotation are positive definite, but not the whole, the terms between them are left out:
/// files in wide use (rim, cubicle) have those in wrong places.
/// @throws InputError "FILE:LINE: field, value, limit" for: a line with too few or too many numbers, numbers
/// that are not finite, positions farther than 1e7 m from the origin, quaternions whose length is not within
/// 1 % of one, information that is not symmetric or has a block that is not positive definite,
/// an id twice, an edge or FIX to a
/// missing node or from a node to itself, tags of the plane and of space in one file, no edges, and nodes
/// that edges do not connect.
G2oGraph ReadG2o(const std::filesystem::path& path);
G2oGraph ParseG2o(std::string_view text, const std::string& file);

/// The vertices alone, as of a file of true poses: edges are neither needed nor read. @throws InputError
/// likewise, and where there are no vertices.
G2oGraph ReadG2oVertices(const std::filesystem::path& path);
G2oGraph ParseG2oVertices(std::string_view text, const std::string& file);

/// Writes vertices, FIX and edges, each number so that it reads back the same. Whole or not at all.
void WriteG2o(const std::filesystem::path& path, const G2oGraph& file);
std::string FormatG2o(const G2oGraph& file);

}  // namespace atlas::mapping
