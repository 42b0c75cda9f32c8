#include <fmt/format.h>

#include <iostream>

#include "core/errors.h"
#include "core/temporary_file.h"
#include "experiments/cli/map_commands.h"
#include "experiments/cli/progress_bar.h"
#include "mapping/io/map_file.h"
#include "mapping/meshing/marching_cubes.h"

namespace atlas::experiments {
namespace {

mapping::AnyOctree LoadMap(const std::filesystem::path& path) {
  ProgressBar bar("map", 1);
  bar.Show(0, "reading " + path.string());
  mapping::AnyOctree map = mapping::ReadMap(path);
  std::visit(
      [&](const auto& tree) {
        const auto counts = tree.Count();
        bar.Finish(fmt::format("{} m voxels, {} chunks, {} surface blocks, {:.1f} MB", tree.resolution_m(),
                               counts.chunks, counts.fine + counts.coarse,
                               static_cast<double>(tree.Bytes()) / 1e6));
      },
      map);
  return map;
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
  const mapping::AnyOctree map = LoadMap(arguments.map);
  const size_t chunks = std::visit([](const auto& tree) { return tree.Count().chunks; }, map);
  ProgressBar bar("mesh", chunks);
  mapping::MeshOptions options;
  options.progress = [&bar](size_t done, size_t) { bar.Show(done, "extracting"); };
  options.min_component_m2 = arguments.min_component_m2;
  options.threads = arguments.threads;
  const core::TriMesh mesh =
      std::visit([&](const auto& tree) { return mapping::ExtractMesh(tree, options); }, map);
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
  const mapping::AnyOctree map = LoadMap(arguments.map);
  if (arguments.out.extension() == ".ply") {
    const core::PointCloud cloud =
        std::visit([](const auto& tree) { return mapping::SurfaceVoxels(tree); }, map);
    core::WritePly(arguments.out, cloud);
    std::cout << fmt::format("{}: {} surface voxels\n", arguments.out.string(), cloud.points.size());
    return 0;
  }
  std::visit([&](const auto& tree) { mapping::ExportOctomap(arguments.out, tree); }, map);
  std::cout << fmt::format("{}: {} bytes\n", arguments.out.string(),
                           std::filesystem::file_size(arguments.out));
  return 0;
}

}  // namespace atlas::experiments
