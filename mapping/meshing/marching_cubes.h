// Surfaces of an octree as triangles: marching cubes across scales, without cracks.
#pragma once

#include <functional>

#include "core/mesh.h"
#include "mapping/octree/octree.h"

namespace atlas::mapping {

struct MeshOptions {
  double min_component_m2 = 0.0;  ///< connected pieces smaller than this are left out
  int threads = 1;
  /// Occupancy: vertices stand on the surface that was seen, OccupancyShift behind the zero level. Off: on
  /// the zero level itself.
  bool undo_shift = true;
  /// Told after each chunk how many of all chunks are done; from one thread at a time.
  std::function<void(size_t done, size_t chunks)> progress = nullptr;
};

/// The zero level of log-odds (occupied inside) or of the signed distance; only where all corners are
/// observed. Vertices are shared, in metres in the map's frame; triangles face free space. Every edge has two
/// triangles except where observed space ends. The same for any number of threads.
/// @pre the octree's summaries are current (Octree::Propagate).
template <typename Field>
core::TriMesh ExtractMesh(const Octree<Field>& map, const MeshOptions& options);

}  // namespace atlas::mapping
