// Every scene by name.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "scenes/scene_spec.h"

namespace atlas::scenes {

struct CatalogEntry {
  std::string name;
  std::string doc;
  SceneSpec (*build)();
};

const std::vector<CatalogEntry>& Catalog();

/// A built-in scene by name, or the user's own from `path/scene.yaml` (docs/scene_files.md).
/// @throws InputError for an unknown name (suggesting the near one) or a bad file.
SceneSpec LoadScene(const std::string& name_or_path);

/// A user's scene file: meshes (OBJ, PLY, STL; scale) and primitives with pose and label, object box, spawn.
SceneSpec LoadSceneFile(const std::filesystem::path& path);

/// Uniform cloud (one point per spacing^2 of area, deterministic) of the object's exposed surfaces: no faces
/// buried inside other solids or below ground.
struct GroundTruth {
  std::vector<core::Vec3f> points;
  std::vector<core::Vec3f> normals;  ///< outward, a point each
  /// 1 where the point lies on a shell that encloses no volume (not watertight): nothing tells its outer
  /// side, so both count. Empty: all shells are closed.
  std::vector<uint8_t> two_sided;
  std::vector<uint16_t> part;  ///< index into part_names, a point each
  std::vector<std::string> part_names;
  std::vector<double> part_area_m2;  ///< exposed area a part name
};
GroundTruth SampleGroundTruth(const SceneSpec& scene, double spacing_m);

}  // namespace atlas::scenes
