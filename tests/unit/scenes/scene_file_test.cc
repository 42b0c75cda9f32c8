#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/errors.h"
#include "core/files.h"
#include "core/rng.h"
#include "scenes/catalog.h"
#include "scenes/ply_reader.h"
#include "scenes/solid_test.h"
#include "tests/support/source_tree.h"
#include "tests/unit/scenes/mesh_checks.h"

namespace atlas::scenes {
namespace {

using core::Vec3;

const std::filesystem::path kExample = atlas::tests::SourceTree() / "scenes/examples/arch.yaml";

class SceneFile : public ::testing::Test {
 protected:
  SceneFile()
      : folder_(std::filesystem::path(::testing::TempDir()) / ("scene_file_" + std::to_string(getpid()))) {
    core::WriteFileAtomically(
        folder_ / "good.obj",
        "v 0 0 0\nv 1000 0 0\nv 0 1000 0\nv 0 0 1000\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    core::WriteFileAtomically(folder_ / "empty.obj", "");
    core::WriteFileAtomically(folder_ / "no_faces.obj", "v 0 0 0\nv 1 0 0\n");
    core::WriteFileAtomically(folder_ / "nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n");
    core::WriteFileAtomically(folder_ / "inf.stl",
                              "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex inf 0 0\nvertex "
                              "0 1 0\nendloop\nendfacet\nendsolid s\n");
    core::WriteFileAtomically(folder_ / "broken.ply", "ply\nformat ascii 1.0\nelement vertex 3\n");
    core::WriteFileAtomically(folder_ / "tetra.txt", "v 0 0 0\n");
  }
  ~SceneFile() override { std::filesystem::remove_all(folder_); }

  struct Mistake {
    std::string yaml;
    std::vector<std::string> says;
  };
  void ExpectEach(const std::vector<Mistake>& mistakes) {
    for (const Mistake& m : mistakes) {
      const std::string error = ErrorOf(m.yaml);
      EXPECT_EQ(error.find('\n'), std::string::npos) << error;
      for (const std::string& part : m.says)
        EXPECT_NE(error.find(part), std::string::npos) << error << "\n  lacks " << part;
    }
  }

  std::string ErrorOf(const std::string& yaml) {
    const std::filesystem::path path = folder_ / "scene.yaml";
    core::WriteFileAtomically(path, yaml);
    try {
      LoadSceneFile(path);
    } catch (const core::InputError& error) {
      return error.what();
    }
    return "no error";
  }

  std::filesystem::path folder_;
};

const std::string kHead = "spawn: {x: -3, y: 0}\nobject_box: {min: [-2, -2, 0.05], max: [2, 2, 2]}\n";

TEST_F(SceneFile, WhatIsAmbiguousOrEndlessIsRefusedByFileAndLine) {
  const std::string file = (folder_ / "scene.yaml").string();
  const std::string box = "parts: [{primitive: box, size: [1, 1, 1]}]\n";
  EXPECT_EQ(ErrorOf(kHead + box), "no error");
  EXPECT_EQ(ErrorOf(kHead + box + box), file + ":4: the key 'parts' stands twice (first in line 3)");
  EXPECT_EQ(ErrorOf(kHead + box + "---\n" + box), file + ":4: a second document (a file holds one)");
  EXPECT_EQ(ErrorOf(kHead + "parts: &a [*a]\n"), file + ":3: an alias stands inside of what it names");
  EXPECT_EQ(ErrorOf(kHead + box + "? [a]\n: 1\n"), file + ":4: a key must be plain text");
  const std::string name = fmt::format("{:x>300}", "");
  EXPECT_NE(ErrorOf(kHead + "parts: [{mesh: " + name + ".obj}]\n").find(name + ".obj: no such file"),
            std::string::npos);
}

TEST_F(SceneFile, EveryMistakeGivesOneLineThatNamesItsPlace) {
  const std::string box = "parts: [{primitive: box, size: [1, 1, 1]}]\n";
  ExpectEach({
      {"spawn: {x: 1\nparts: [", {"scene.yaml:", "malformed YAML"}},
      {"", {"expected a mapping"}},
      {"- 1\n", {"expected a mapping"}},
      {kHead + box + "spwan: 3\n", {"scene.yaml:4", "unknown key 'spwan'", "'spawn'"}},
      {box, {"missing field 'spawn'"}},
      {"spawn: {x: 0}\n" + kHead.substr(kHead.find('\n') + 1) + box,
       {"scene.yaml:1: spawn: missing field 'y'"}},
      {"spawn: {x: no, y: 0}\n" + kHead.substr(kHead.find('\n') + 1) + box,
       {"scene.yaml:1: spawn.x", "expected a number", "'no'"}},
      {"spawn: 3\n" + box, {"spawn: expected a mapping"}},
      {kHead, {"missing field 'parts'"}},
      {kHead + "parts: 5\n", {"parts: expected a list"}},
      {kHead + "parts: [7]\n", {"parts[0]: expected a mapping"}},
      {kHead + "parts: [{label: wall}]\n", {"parts[0]: a part needs either 'mesh' or 'primitive'"}},
      {kHead + "parts: [{primitive: bax, size: [1, 1, 1]}]\n", {"unknown primitive 'bax'", "'box'"}},
      {kHead + "parts: [{primitive: box, size: [1, 1]}]\n", {"parts[0].size", "3 numbers", "2 entries"}},
      {kHead + "parts: [{primitive: box, size: [1, 0, 1]}]\n", {"parts[0].size", "above 0"}},
      {kHead + "parts: [{primitive: box, size: [1, 1, .nan]}]\n", {"not finite"}},
      {kHead + "parts: [{primitive: box, size: [1, 1, 1], radius: 2}]\n", {"parts[0]: unknown key 'radius'"}},
      {kHead + "parts: [{primitive: sphere, radius: -1}]\n", {"parts[0].radius", "-1"}},
      {kHead + "parts: [{primitive: capsule, radius: 1, height: 1}]\n", {"twice its radius"}},
      {kHead + "parts: [{primitive: box, size: [1, 1, 1], label: wal}]\n", {"unknown label 'wal'", "'wall'"}},
      {kHead + "parts: [{primitive: box, size: [1, 1, 1], object: maybe}]\n",
       {"parts[0].object", "true or false"}},
      {kHead + "parts: [{primitive: box, size: [1, 1, 1], object: false}]\n", {"no part is the object"}},
      {kHead + "parts: [{primitive: box, size: [1, 1, 1], pose: {xyz: [9, 9, 9]}}]\n",
       {"object_box", "holds no part"}},
      {kHead + "parts: [{primitive: box, size: [1, 1, 1], pose: {rpy: [9, 9, 9]}}]\n",
       {"parts[0].pose: unknown key 'rpy'"}},
      {kHead + "parts: [{primitive: box, size: [3, 3, 3], pose: {xyz: [-2, 0, 1]}}]\n",
       {"spawn", "inside part 'box'"}},
      {"spawn: {x: 99, y: 0}\n" + kHead.substr(kHead.find('\n') + 1) + box, {"spawn", "outside the ground"}},
      {"spawn: {x: 4, y: 0}\nobject_box: {min: [0, 3, 0], max: [1, 2, 3]}\n" + box,
       {"scene.yaml:2: object_box.min", "y = 3", "max y = 2"}},
      {kHead + box + "ground: {size: [0, 3]}\n", {"ground.size", "above 0"}},
  });
}

TEST_F(SceneFile, EveryMistakeInAMeshGivesOneLineThatNamesItsPlace) {
  ExpectEach({
      {kHead + "parts: [{mesh: absent.obj}]\n",
       {"scene.yaml:3", "parts[0].mesh", "absent.obj: no such file"}},
      {kHead + "parts: [{mesh: empty.obj}]\n", {"empty.obj: the file is empty"}},
      {kHead + "parts: [{mesh: no_faces.obj}]\n", {"no_faces.obj"}},
      {kHead + "parts: [{mesh: nan.obj}]\n", {"parts[0].mesh", "nan.obj", "not finite"}},
      {kHead + "parts: [{mesh: inf.stl}]\n", {"parts[0].mesh", "inf.stl"}},
      {kHead + "parts: [{mesh: broken.ply}]\n", {"broken.ply"}},
      {kHead + "parts: [{mesh: tetra.txt}]\n", {"tetra.txt", ".obj, .ply, .stl"}},
      {kHead + "parts: [{mesh: good.obj}]\n", {"no error"}},
      {kHead + "parts: [{mesh: good.obj, scale: 10}]\n", {"spans 10000 m", "0.001"}},
      {kHead + "parts: [{mesh: good.obj, scale: 0}]\n", {"parts[0].scale", "above 0"}},
      {kHead + "parts: [{mesh: good.obj, scale: 0.001, collision: hul}]\n",
       {"unknown collision 'hul'", "'hull'"}},
      {kHead + "parts: [{mesh: good.obj, scale: 0.001}]\n", {"no error"}},
  });
}

TEST_F(SceneFile, ControlCharactersAreRefusedAndProseMayHaveLines) {
  const std::string part = "parts: [{primitive: box, size: [1, 1, 1]";
  for (const std::string value : {"name: \"a\\nb\"", "name: \"a\\e[2Jb\""}) {
    const std::string error = ErrorOf(kHead + part + ", " + value + "}]\n");
    EXPECT_NE(error.find("scene.yaml:3: parts[0].name: holds a control character"), std::string::npos)
        << error;
  }
  EXPECT_EQ(ErrorOf("doc: |\n  two\n  lines\n" + kHead + part + "}]\n"), "no error");
}

TEST_F(SceneFile, PlyIsReadInEveryFormatAndRefusedWhenCutShort) {
  const std::string head =
      "element vertex 4\nproperty float x\nproperty float y\nproperty double z\nelement face 2\nproperty "
      "list uchar int vertex_indices\nend_header\n";
  std::string ascii = "ply\nformat ascii 1.0\n" + head + "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n4 0 1 2 3\n";
  const auto pack = [&](const std::string& format, bool swap) {
    std::string bytes = "ply\nformat " + format + " 1.0\n" + head;
    const auto put = [&](auto value) {
      std::string raw(reinterpret_cast<const char*>(&value), sizeof(value));
      if (swap) std::reverse(raw.begin(), raw.end());
      bytes += raw;
    };
    for (const auto& [x, y] : {std::pair{0.f, 0.f}, {1.f, 0.f}, {1.f, 1.f}, {0.f, 1.f}})
      put(x), put(y), put(0.0);
    put(uint8_t{3}), put(int32_t{0}), put(int32_t{1}), put(int32_t{2});
    put(uint8_t{4}), put(int32_t{0}), put(int32_t{1}), put(int32_t{2}), put(int32_t{3});
    return bytes;
  };
  for (const std::string& whole :
       {ascii, pack("binary_little_endian", false), pack("binary_big_endian", true)}) {
    const core::TriMesh mesh = ParsePly(whole);
    EXPECT_EQ(mesh.vertices.size(), 4u);
    EXPECT_EQ(mesh.triangles.size(), 3u);
    EXPECT_NEAR(mesh.AreaM2(), 1.5, 1e-9);
    for (size_t cut = 0; cut + 2 < whole.size(); cut += 7) {
      EXPECT_THROW(ParsePly(std::string_view(whole).substr(0, cut)), core::InputError) << cut;
    }
  }
  ascii.replace(ascii.find("4 0 1 2 3"), 9, "4 0 1 2 9");
  EXPECT_THROW(ParsePly(ascii), core::InputError);
}

TEST_F(SceneFile, MissingFileIsNamed) {
  EXPECT_THROW(LoadScene((folder_ / "none.yaml").string()), core::InputError);
}

TEST_F(SceneFile, MeshScalePoseAndHullAreApplied) {
  const std::filesystem::path path = folder_ / "scene.yaml";
  core::WriteFileAtomically(path, kHead +
                                      "parts: [{mesh: good.obj, scale: 0.001, label: rock, pose: {xyz: [0.5, "
                                      "0, 0], rpy_deg: [0, 0, 90]}}]\n");
  const SceneSpec scene = LoadScene(path.string());
  const ScenePart& part = scene.parts.at(1);
  EXPECT_EQ(part.name, "good");
  EXPECT_EQ(part.label, core::Label::kRock);
  const core::Box3 box = part.mesh.Bounds();
  EXPECT_LT((box.min - Vec3(-0.5, 0, 0)).norm(), 1e-6);
  EXPECT_LT((box.max - Vec3(0.5, 1, 1)).norm(), 1e-6);
  // Closed and convex, so `auto` takes its hull, which is itself.
  ASSERT_EQ(part.collision.size(), 1u);
  EXPECT_NEAR(VolumeByFlux(std::get<HullShape>(part.collision[0].shape).mesh), 1.0 / 6.0, 1e-5);
}

TEST_F(SceneFile, PrimitivesCollideAsWhatTheyAre) {
  const std::filesystem::path path = folder_ / "scene.yaml";
  core::WriteFileAtomically(path, kHead +
                                      "parts:\n"
                                      "  - {primitive: box, size: [1, 2, 3]}\n"
                                      "  - {primitive: cylinder, radius: 0.2, height: 1}\n"
                                      "  - {primitive: sphere, radius: 0.3, object: false}\n"
                                      "  - {primitive: capsule, radius: 0.1, height: 1}\n");
  const SceneSpec scene = LoadSceneFile(path);
  EXPECT_EQ(std::get<BoxShape>(scene.parts[1].collision[0].shape).half_size, Vec3(0.5, 1, 1.5));
  EXPECT_EQ(std::get<CylinderShape>(scene.parts[2].collision[0].shape).half_length, 0.5);
  EXPECT_EQ(std::get<SphereShape>(scene.parts[3].collision[0].shape).radius, 0.3);
  EXPECT_NEAR(std::get<CapsuleShape>(scene.parts[4].collision[0].shape).half_length, 0.4, 1e-12);
  EXPECT_FALSE(scene.parts[3].is_object);
  for (const ScenePart& part : scene.parts) EXPECT_EQ(UnpairedEdges(part.mesh), 0) << part.name;
}

TEST(ExampleScene, IsAConcaveOpenMillimetreMeshThatARobotCanWalkUnder) {
  const SceneSpec scene = LoadScene(kExample.string());
  const ScenePart& arch = scene.parts.at(1);
  EXPECT_GT(arch.mesh.triangles.size(), 2000u);
  EXPECT_FALSE(IsWatertight(arch.mesh));
  EXPECT_NEAR(arch.mesh.Bounds().Size().z(), 2.7, 0.2);
  EXPECT_GT(arch.collision.size(), 100u);
  EXPECT_LE(arch.collision.size(), 600u);
  // No prism reaches into a passage of 1.6 x 1.3 m along x; a hull of the whole would fill it.
  for (const CollisionShape& shape : arch.collision) {
    for (const core::Vec3f& v : std::get<HullShape>(shape.shape).mesh.vertices) {
      EXPECT_FALSE(std::abs(v.y()) < 0.8f && v.z() < 1.3f) << v.transpose();
    }
  }
}

TEST(ExampleScene, PrismsFollowTheStone) {
  const SceneSpec scene = LoadScene(kExample.string());
  const ScenePart& arch = scene.parts.at(1);
  // Every reachable corner of the stone is within a few centimetres of a prism's corner set.
  std::vector<core::Vec3f> corners;
  for (const CollisionShape& shape : arch.collision) {
    for (const core::Vec3f& v : std::get<HullShape>(shape.shape).mesh.vertices) corners.push_back(v);
  }
  for (const core::Vec3f& v : arch.mesh.vertices) {
    if (v.z() > 1.2f) continue;
    float nearest = 1e9f;
    for (const core::Vec3f& c : corners) nearest = std::min(nearest, (c - v).norm());
    EXPECT_LT(nearest, 0.13f) << v.transpose();
  }
}

}  // namespace
}  // namespace atlas::scenes
