#include "mapping/meshing/marching_cubes.h"

#include <atomic>
#include <mutex>
#include <unordered_map>

#include "core/parallel_for.h"
#include "mapping/meshing/chunk_surface.h"
#include "mapping/meshing/mesh_pieces.h"

namespace atlas::mapping {
namespace {

/// A surface for each chunk, in the same order; workers take the next chunk that nobody has.
template <typename Field>
std::vector<ChunkSurface> ExtractChunks(const Octree<Field>& map, const MeshOptions& options) {
  const std::vector<const typename Octree<Field>::Chunk*> chunks = map.Chunks();
  std::vector<ChunkSurface> surfaces(chunks.size());
  std::atomic<size_t> next = 0;
  std::mutex telling;
  size_t done = 0;
  const auto workers = static_cast<size_t>(std::max(options.threads, 1));
  core::ParallelFor(options.threads, workers, [&](size_t, size_t, size_t) {
    ChunkMesher<Field> mesher(map, options.undo_shift);
    for (size_t i = next++; i < chunks.size(); i = next++) {
      surfaces[i] = mesher.Extract(*chunks[i]);
      if (!options.progress) continue;
      const std::lock_guard lock(telling);
      options.progress(++done, chunks.size());
    }
  });
  return surfaces;
}

struct EdgeKey {
  NodeKey voxel;
  int axis;
  friend bool operator==(const EdgeKey&, const EdgeKey&) = default;
};
struct EdgeHash {
  size_t operator()(const EdgeKey& e) const {
    uint64_t h = static_cast<uint32_t>(e.voxel.x) * 0x9e3779b97f4a7c15ull;
    h = (h ^ h >> 29 ^ static_cast<uint32_t>(e.voxel.y)) * 0xbf58476d1ce4e5b9ull;
    h = (h ^ h >> 32 ^ static_cast<uint32_t>(e.voxel.z)) * 0x94d049bb133111ebull;
    return static_cast<size_t>((h ^ h >> 31) * 4 + static_cast<uint64_t>(e.axis));
  }
};

/// Appends the surfaces one after another; a vertex that several share stands where the first has it.
core::TriMesh Join(std::vector<ChunkSurface> surfaces) {
  core::TriMesh mesh;
  size_t vertices = 0, triangles = 0, shared = 0;
  for (const ChunkSurface& s : surfaces) {
    vertices += s.mesh.vertices.size();
    triangles += s.mesh.triangles.size();
    shared += s.shared.size();
  }
  mesh.vertices.reserve(vertices);
  mesh.triangles.reserve(triangles);
  std::unordered_map<EdgeKey, uint32_t, EdgeHash> vertex_on;
  vertex_on.reserve(shared);
  std::vector<uint32_t> place;
  for (ChunkSurface& s : surfaces) {
    constexpr uint32_t kNew = ~0u;
    place.assign(s.mesh.vertices.size(), kNew);
    for (const ChunkSurface::Shared& v : s.shared) {
      const auto found = vertex_on.find({v.voxel, v.axis});
      if (found != vertex_on.end()) place[v.vertex] = found->second;
    }
    for (size_t v = 0; v < place.size(); ++v) {
      if (place[v] != kNew) continue;
      place[v] = static_cast<uint32_t>(mesh.vertices.size());
      mesh.vertices.push_back(s.mesh.vertices[v]);
    }
    for (const ChunkSurface::Shared& v : s.shared) vertex_on.try_emplace({v.voxel, v.axis}, place[v.vertex]);
    for (const auto& t : s.mesh.triangles) mesh.triangles.push_back({place[t[0]], place[t[1]], place[t[2]]});
    s = {};
  }
  return mesh;
}

}  // namespace

template <typename Field>
core::TriMesh ExtractMesh(const Octree<Field>& map, const MeshOptions& options) {
  core::TriMesh mesh = Join(ExtractChunks(map, options));
  if (options.min_component_m2 > 0.0) DropSmallPieces(options.min_component_m2, &mesh);
  return mesh;
}

template core::TriMesh ExtractMesh(const Octree<OccupancyField>&, const MeshOptions&);
template core::TriMesh ExtractMesh(const Octree<TsdfField>&, const MeshOptions&);

}  // namespace atlas::mapping
