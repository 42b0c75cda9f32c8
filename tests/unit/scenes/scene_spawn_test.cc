// Degrees of a scene file are degrees.
#include <gtest/gtest.h>
#include <unistd.h>

#include "core/files.h"
#include "scenes/catalog.h"

namespace atlas::scenes {
namespace {

TEST(SceneSpawn, LooksWhereItsDegreesSay) {
  const auto folder = std::filesystem::temp_directory_path() / ("atlas_spawn_" + std::to_string(::getpid()));
  core::WriteFileAtomically(folder / "scene.yaml",
                            "spawn: {x: -3.0, y: 1.5, yaw_deg: 30}\n"
                            "object_box: {min: [-1, -1, 0.05], max: [1, 1, 2]}\n"
                            "parts:\n  - {primitive: box, size: [1, 1, 1], pose: {xyz: [0, 0, 0.5]}}\n");
  const SceneSpec scene = LoadScene((folder / "scene.yaml").string());
  EXPECT_LT((scene.T_map_spawn.translation() - core::Vec3(-3.0, 1.5, 0.0)).norm(), 1e-12);
  EXPECT_NEAR(core::Degrees(core::YawOf(scene.T_map_spawn.linear())), 30.0, 1e-9);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace atlas::scenes
