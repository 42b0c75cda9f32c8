#include <algorithm>

#include "mapping/atlas/saved_atlas.h"
#include "mapping/atlas/submap_fusion.h"
#include "mapping/meshing/mesh_pieces.h"

namespace atlas::mapping {

core::TriMesh ExtractMesh(const AtlasView& view, const MeshOptions& options) {
  MeshOptions each = options;
  each.min_component_m2 = 0.0;  // what a newer submap cuts off may hang together through it
  each.progress = nullptr;
  core::TriMesh all;
  for (size_t i = 0; i < view.submaps().size(); ++i) {
    const PosedSubmap& submap = view.submaps()[i];
    const auto contents = submap.contents->Get();
    core::TriMesh mesh =
        contents->distances ? ExtractMesh(*contents->distances, each) : ExtractMesh(contents->tree, each);
    mesh.Transform(submap.T_map_submap);
    std::erase_if(mesh.triangles, [&](const std::array<uint32_t, 3>& t) {
      const core::Vec3f middle = (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3.0f;
      return view.RightAbout(middle.cast<double>()) < i;
    });
    all.Append(mesh);
    if (options.progress) options.progress(i + 1, view.submaps().size());
  }
  DropSmallPieces(options.min_component_m2, &all);
  return all;
}

core::TriMesh ExtractMesh(const SavedAtlas& atlas, const MeshOptions& options) {
  return ExtractMesh(*atlas.View(), options);
}

core::PointCloud SurfaceVoxels(const SavedAtlas& atlas) {
  return {OccupiedCenters(*atlas.View(), TraceLimits{}.box_map)};
}

OccupancyOctree OnOneLattice(const SavedAtlas& atlas) {
  OctreeContents all{OccupancyOctree(atlas.resolution_m), {}};
  for (const SavedSubmap& submap : atlas.submaps)
    FuseInto(*submap.contents->Get(), submap.T_map_submap, FusionRule::kFirst, &all);
  return std::move(all.tree);
}

}  // namespace atlas::mapping
