#include "scenes/scene_files.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/errors.h"
#include "core/files.h"
#include "scenes/catalog.h"

namespace atlas::scenes {
namespace {
namespace fs = std::filesystem;

constexpr const char* kSceneHead =
    "# a comment\nspawn: {x: -4, y: 0}\nobject_box: {min: [-1, -1, 0.05], max: [1, 1, 2]}\nparts:\n";
constexpr const char* kTetrahedron =
    "v 0 0 0.1\nv 1 0 0.1\nv 0 1 0.1\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

class SceneFiles : public ::testing::Test {
 protected:
  SceneFiles() {
    fs::remove_all(root_);
    Write("meshes/one/body.obj", kTetrahedron);
    Write("meshes/two/body.obj", fmt::format("{}v 0.1 0.1 1.5\nf 2 3 5\n", kTetrahedron));
    Write("scenes/mine.yaml",
          fmt::format("{}  - {{mesh: ../meshes/one/body.obj}}\n  - {{mesh: {}, scale: 0.5}}\n"
                      "  - {{primitive: box, size: [1, 1, 1], pose: {{xyz: [0, 0, 1]}}}}\n",
                      kSceneHead, (root_ / "meshes/two/body.obj").string()));
  }
  ~SceneFiles() override { fs::remove_all(root_); }
  void Write(const std::string& name, const std::string& text) const {
    core::WriteFileAtomically(root_ / name, text);
  }
  std::string Digest() const { return SceneDigest((root_ / "scenes/mine.yaml").string()); }

  const fs::path root_ = fs::temp_directory_path() / "atlas_scene_files";
};

TEST_F(SceneFiles, ACopyIsTheSameSceneWithoutTheOriginals) {
  const SceneSpec scene = LoadSceneFile(root_ / "scenes/mine.yaml");
  const std::string digest = Digest();
  EXPECT_EQ(CopyScene(root_ / "scenes/mine.yaml", root_ / "run/scene"), "mine.yaml");
  fs::remove_all(root_ / "scenes");
  fs::remove_all(root_ / "meshes");
  fs::rename(root_ / "run", root_ / "moved");
  const SceneSpec copy = LoadSceneFile(root_ / "moved/scene/mine.yaml");
  ASSERT_EQ(copy.parts.size(), scene.parts.size());
  for (size_t i = 0; i < scene.parts.size(); ++i) {
    EXPECT_EQ(copy.parts[i].name, scene.parts[i].name);
    EXPECT_EQ(copy.parts[i].mesh.vertices, scene.parts[i].mesh.vertices);
    EXPECT_EQ(copy.parts[i].mesh.triangles, scene.parts[i].mesh.triangles);
    EXPECT_EQ(copy.parts[i].collision.size(), scene.parts[i].collision.size());
  }
  EXPECT_EQ(copy.name, scene.name);
  EXPECT_EQ(copy.object_box.max, scene.object_box.max);
  EXPECT_EQ(SceneDigest((root_ / "moved/scene/mine.yaml").string()), digest);
}

TEST_F(SceneFiles, TheDigestFollowsFieldsAndMeshesNotComments) {
  const std::string digest = Digest();
  EXPECT_TRUE(digest.starts_with("mine-")) << digest;
  std::string text = core::ReadFile(root_ / "scenes/mine.yaml");
  Write("scenes/mine.yaml", "# more\n" + text);
  EXPECT_EQ(Digest(), digest);
  std::string moved = text;
  moved.replace(moved.find("x: -4"), 5, "x: -5");
  Write("scenes/mine.yaml", moved);
  EXPECT_NE(Digest(), digest);
  Write("scenes/mine.yaml", text);
  EXPECT_EQ(Digest(), digest);
  Write("meshes/one/body.obj", fmt::format("{}\n", kTetrahedron));
  EXPECT_NE(Digest(), digest);
}

TEST_F(SceneFiles, BuiltInScenesAreToldByTheirNames) {
  EXPECT_EQ(SceneDigest("car"), "car");
  EXPECT_THROW(SceneDigest("absent.yaml"), core::InputError);
}

TEST_F(SceneFiles, TheShippedExampleSurvivesTheCopy) {
  const fs::path arch = core::InstalledFile("scenes/examples/arch.yaml");
  CopyScene(arch, root_ / "copy");
  EXPECT_EQ(SceneDigest((root_ / "copy/arch.yaml").string()), SceneDigest(arch.string()));
  EXPECT_EQ(LoadSceneFile(root_ / "copy/arch.yaml").parts.size(), LoadSceneFile(arch).parts.size());
}

}  // namespace
}  // namespace atlas::scenes
