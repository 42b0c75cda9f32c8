#include <fmt/format.h>

#include <iostream>
#include <variant>

#include "core/errors.h"
#include "core/temporary_file.h"
#include "experiments/cli/map_commands.h"
#include "experiments/cli/progress_bar.h"
#include "mapping/atlas/saved_atlas.h"
#include "mapping/io/map_file.h"
#include "mapping/meshing/marching_cubes.h"

namespace atlas::experiments {
namespace {

using Opened = std::variant<mapping::OccupancyOctree, mapping::TsdfOctree, mapping::SavedAtlas>;

std::string WhatIsThere(const mapping::SavedAtlas& atlas) {
  size_t keyframes = 0;
  for (const mapping::SavedSubmap& submap : atlas.submaps) keyframes += submap.keyframes.size();
  return fmt::format("{} m voxels, {} submaps, {} keyframes", atlas.resolution_m, atlas.submaps.size(),
                     keyframes);
}
template <typename Field>
std::string WhatIsThere(const mapping::Octree<Field>& tree) {
  const auto counts = tree.Count();
  return fmt::format("{} m voxels, {} chunks, {} surface blocks, {:.1f} MB", tree.resolution_m(),
                     counts.chunks, counts.fine + counts.coarse, static_cast<double>(tree.Bytes()) / 1e6);
}

/// A map file, or the folder of an atlas.
Opened OpenMap(const std::filesystem::path& path) {
  ProgressBar bar("map", 1);
  bar.Show(0, "reading " + path.string());
  Opened opened =
      mapping::IsAtlasFolder(path)
          ? Opened(mapping::LoadAtlas(path))
          : std::visit([](auto&& tree) { return Opened(std::move(tree)); }, mapping::ReadMap(path));
  std::visit([&](const auto& map) { bar.Finish(WhatIsThere(map)); }, opened);
  return opened;
}

/// Of which a mesh is made one by one.
size_t PartsOf(const mapping::SavedAtlas& atlas) {
  return atlas.submaps.size();
}
template <typename Field>
size_t PartsOf(const mapping::Octree<Field>& tree) {
  return tree.Count().chunks;
}

void CheckExtension(const std::filesystem::path& path, const std::vector<std::string>& valid) {
  const std::string extension = path.extension();
  if (std::find(valid.begin(), valid.end(), extension) != valid.end()) return;
  throw core::InputError(
      fmt::format("--out {}: {}", path.string(), core::UnknownName("extension", extension, valid)));
}

}  // namespace

int MeshCommand(const MeshArguments& arguments) {
  const std::filesystem::path out =
      arguments.out.empty() ? arguments.map.parent_path() / "mesh.ply" : arguments.out;
  CheckExtension(out, {".ply"});
  core::RemoveStaleTemporaries(out.parent_path());
  const Opened map = OpenMap(arguments.map);
  const size_t chunks = std::visit([](const auto& opened) { return PartsOf(opened); }, map);
  ProgressBar bar("mesh", chunks);
  mapping::MeshOptions options;
  options.progress = [&bar](size_t done, size_t) { bar.Show(done, "extracting"); };
  options.min_component_m2 = arguments.min_component_m2;
  options.threads = arguments.threads;
  const core::TriMesh mesh =
      std::visit([&](const auto& opened) { return mapping::ExtractMesh(opened, options); }, map);
  bar.Show(chunks, "writing " + out.string());
  core::WritePly(out, mesh);
  bar.Finish(fmt::format("{} triangles, {} vertices", mesh.triangles.size(), mesh.vertices.size()));
  std::cout << fmt::format("{}: {} triangles, {} vertices, {:.2f} m2\n", out.string(), mesh.triangles.size(),
                           mesh.vertices.size(), mesh.AreaM2());
  return 0;
}

int ExportCommand(const ExportArguments& arguments) {
  CheckExtension(arguments.out, {".bt", ".ot", ".ply"});
  core::RemoveStaleTemporaries(arguments.out.parent_path());
  Opened map = OpenMap(arguments.map);
  if (arguments.out.extension() == ".ply") {
    const core::PointCloud cloud =
        std::visit([](const auto& opened) { return mapping::SurfaceVoxels(opened); }, map);
    core::WritePly(arguments.out, cloud);
    std::cout << fmt::format("{}: {} surface voxels\n", arguments.out.string(), cloud.points.size());
    return 0;
  }
  if (const auto* atlas = std::get_if<mapping::SavedAtlas>(&map)) map = mapping::OnOneLattice(*atlas);
  if (const auto* tree = std::get_if<mapping::OccupancyOctree>(&map))
    mapping::ExportOctomap(arguments.out, *tree);
  if (const auto* tree = std::get_if<mapping::TsdfOctree>(&map)) mapping::ExportOctomap(arguments.out, *tree);
  std::cout << fmt::format("{}: {} bytes\n", arguments.out.string(),
                           std::filesystem::file_size(arguments.out));
  return 0;
}

}  // namespace atlas::experiments
