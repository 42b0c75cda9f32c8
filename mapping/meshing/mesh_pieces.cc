#include "mapping/meshing/mesh_pieces.h"

#include <limits>
#include <numeric>

namespace atlas::mapping {
namespace {

/// Disjoint sets of vertices; a set's root is its smallest member.
class Pieces {
 public:
  explicit Pieces(size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }
  uint32_t Root(uint32_t v) {
    while (parent_[v] != v) v = parent_[v] = parent_[parent_[v]];
    return v;
  }
  void Join(uint32_t a, uint32_t b) {
    a = Root(a);
    b = Root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<uint32_t> parent_;
};

double AreaOf(const core::TriMesh& mesh, const std::array<uint32_t, 3>& t) {
  const core::Vec3f &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
  return 0.5 * static_cast<double>((b - a).cross(c - a).norm());
}

void DropUnusedVertices(core::TriMesh* mesh) {
  constexpr uint32_t kUnused = std::numeric_limits<uint32_t>::max();
  std::vector<uint32_t> place(mesh->vertices.size(), kUnused);
  for (const auto& t : mesh->triangles) {
    for (const uint32_t v : t) place[v] = 0;
  }
  uint32_t kept = 0;
  for (size_t v = 0; v < place.size(); ++v) {
    if (place[v] == kUnused) continue;
    mesh->vertices[kept] = mesh->vertices[v];
    place[v] = kept++;
  }
  mesh->vertices.resize(kept);
  for (auto& t : mesh->triangles) {
    for (uint32_t& v : t) v = place[v];
  }
}

}  // namespace

void DropSmallPieces(double min_area_m2, core::TriMesh* mesh) {
  Pieces pieces(mesh->vertices.size());
  for (const auto& t : mesh->triangles) {
    pieces.Join(t[0], t[1]);
    pieces.Join(t[0], t[2]);
  }
  std::vector<double> area_m2(mesh->vertices.size(), 0.0);
  for (const auto& t : mesh->triangles) area_m2[pieces.Root(t[0])] += AreaOf(*mesh, t);
  std::erase_if(mesh->triangles, [&](const auto& t) { return area_m2[pieces.Root(t[0])] < min_area_m2; });
  DropUnusedVertices(mesh);
}

}  // namespace atlas::mapping
