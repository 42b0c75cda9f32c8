// An atlas written, opened again, damaged.
#include "mapping/atlas/saved_atlas.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>

#include "core/checksum.h"
#include "core/errors.h"
#include "core/files.h"
#include "mapping/atlas/atlas.h"
#include "tests/support/moved_keyframes.h"
#include "tests/support/room_sweep.h"

namespace atlas::tests {
namespace {

using namespace mapping;
using core::KeyframeId;
using core::Pose;
using core::Vec3;
namespace fs = std::filesystem;

/// Two submaps that overlap, the second one turned and shifted by half a metre.
struct SavedAtlasTest : ::testing::Test {
  SavedAtlasTest() {
    AtlasParams params;
    params.cloud_overlap = 1.0;
    params.reentry = false;
    params.fusion_overlap = 0.0;
    atlas = std::make_unique<Atlas>(params, AtlasSetup{.resolution_m = 0.05, .integrator = {}, .map = {}});
    const PlacedSpins room = RoomSweep(12, 0.0);
    std::vector<Pose> T_map_keyframe(2, Pose::Identity());
    T_map_keyframe[1] = core::PoseFromXyzYaw(Vec3(0.5, 0.1, 0.0), 0.2);
    const MovedKeyframes poses(T_map_keyframe);
    for (KeyframeId k = 0; k < 12; ++k)
      atlas->Integrate({.spin = Shared(room.spins[k]), .keyframe = k / 6}, poses);
    folder = fs::path(::testing::TempDir()) /
             ("saved_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder);
    WriteAtlas(folder, atlas->Saved());
  }
  ~SavedAtlasTest() override { fs::remove_all(folder); }

  std::vector<fs::path> Files() const {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
  }
  void Replace(const fs::path& file, const std::string& content) const {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << content;
  }
  /// One line that names a file of the folder.
  void ExpectRefused(const std::string& what) const {
    try {
      LoadAtlas(folder);
      ADD_FAILURE() << what << ": opened";
    } catch (const core::InputError& error) {
      const std::string message = error.what();
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
      EXPECT_NE(message.find(folder.string()), std::string::npos) << message;
    }
  }
  /// files.csv anew, as if the folder had been written so.
  void Relist() const {
    std::string list = "file,bytes,crc64\n";
    for (const fs::path& file : Files()) {
      if (file.filename() == "files.csv") continue;
      const std::string content = core::ReadFile(file);
      list += fmt::format("{},{},{:016x}\n", file.filename().string(), content.size(), core::Crc64(content));
    }
    Replace(folder / "files.csv",
            list + fmt::format("files.csv,{},{:016x}\n", list.size(), core::Crc64(list)));
  }

  std::unique_ptr<Atlas> atlas;
  fs::path folder;
};

TEST_F(SavedAtlasTest, OpensAsTheMapThatItWas) {
  EXPECT_TRUE(IsAtlasFolder(folder));
  const SavedAtlas opened = LoadAtlas(folder);
  ASSERT_EQ(opened.submaps.size(), 2u);
  const auto was = atlas->Snapshot(), is = opened.View();
  EXPECT_EQ(is->resolution_m(), was->resolution_m());
  const std::vector<core::Vec3f> before = OccupiedCenters(*was, TraceLimits{}.box_map),
                                 after = OccupiedCenters(*is, TraceLimits{}.box_map);
  ASSERT_GT(before.size(), 1000u);
  ASSERT_EQ(before.size(), after.size());
  for (size_t i = 0; i < before.size(); ++i) ASSERT_LT((before[i] - after[i]).norm(), 1e-5f);
  core::Rng rng(1);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p(rng.Uniform(-3.0, 3.0), rng.Uniform(-3.0, 3.0), rng.Uniform(-0.5, 3.0));
    EXPECT_EQ(was->StateAt(p), is->StateAt(p));
  }
  for (size_t s = 0; s < 2; ++s) {
    const Submap& submap = *atlas->submaps()[1 - s];  // the newest first
    EXPECT_EQ(opened.submaps[s].id, submap.id);
    EXPECT_EQ(opened.submaps[s].root, submap.root);
    ASSERT_EQ(opened.submaps[s].keyframes.size(), 1u);
    EXPECT_EQ(opened.submaps[s].keyframes[0].sensor.keyframe, submap.root);
    ASSERT_EQ(opened.submaps[s].clouds.size(), 1u);
    EXPECT_TRUE(opened.submaps[s].clouds[0].points == submap.clouds[0].points.Points());
  }
}

TEST_F(SavedAtlasTest, WrittenAgainItIsTheSameFolder) {
  const fs::path again = folder.string() + "_again";
  fs::remove_all(again);
  WriteAtlas(again, LoadAtlas(folder));
  for (const fs::path& file : Files())
    EXPECT_TRUE(core::ReadFile(file) == core::ReadFile(again / file.filename())) << file;
  fs::remove_all(again);
}

TEST_F(SavedAtlasTest, EveryFlippedByteIsFoundOut) {
  core::Rng rng(9);
  for (const fs::path& file : Files()) {
    const std::string whole = core::ReadFile(file);
    for (int i = 0; i < 6; ++i) {
      std::string damaged = whole;
      damaged[static_cast<size_t>(rng.Uniform(0.0, static_cast<double>(whole.size())))] ^= 0x11;
      Replace(file, damaged);
      ExpectRefused(file.filename().string());
    }
    Replace(file, whole.substr(0, whole.size() / 2));
    ExpectRefused(file.filename().string() + " cut");
    Replace(file, whole);
  }
  LoadAtlas(folder);
}

TEST_F(SavedAtlasTest, EveryMissingFileIsFoundOut) {
  for (const fs::path& file : Files()) {
    const std::string whole = core::ReadFile(file);
    fs::remove(file);
    ExpectRefused(file.filename().string() + " gone");
    Replace(file, whole);
  }
}

TEST_F(SavedAtlasTest, ValuesOutOfTheirRangeAreRefusedThoughChecksumsHold) {
  const auto with = [&](const std::string& name, const std::string& from, const std::string& to) {
    const std::string whole = core::ReadFile(folder / name);
    std::string changed = whole;
    const size_t at = changed.rfind(from);
    ASSERT_NE(at, std::string::npos) << name << " " << from;
    changed.replace(at, from.size(), to);
    Replace(folder / name, changed);
    Relist();
    ExpectRefused(name + ": " + to);
    Replace(folder / name, whole);
    Relist();
  };
  with("submaps.csv", "\n0,0,1,", "\n0,0,2,");  // a keyframe that is not there
  with("submaps.csv", "\n0,0,1,", "\n1,0,1,");  // twice
  with("submaps.csv", "\n0,0,1,", "\n-1,0,1,");
  with("submaps.csv", "\n0,0,1,", "\nnan,0,1,");
  with("submaps.csv", "submap_000.atlas", "../x.atlas");
  with("submaps.csv", "submap_000.atlas", "submap_007.atlas");  // missing
  with("submaps.csv", ",1.000000000000\n", ",2\n");             // qw
  with("submaps.csv", ",1.000000000000\n", ",0.5\n");
  with("submaps.csv", ",1.000000000000\n", "\n");
  with("keyframes.csv", "\n0,0,", "\n0,9,");  // of no submap
  with("keyframes.csv", "\n0,0,", "\n0,0,inf,");
  with("clouds.csv", "cloud_000_0.ply", "submap_000.atlas");
  with("atlas.csv", "\n1,0.05", "\n2,0.05");  // a later format
  with("atlas.csv", "\n1,0.05", "\n1,0.06");
  with("atlas.csv", "\n1,0.05", "\n1,nan");
  LoadAtlas(folder);
}

TEST_F(SavedAtlasTest, OneMeshHasEachSurfaceOnceTheNewestOneWhereSubmapsOverlap) {
  const SavedAtlas opened = LoadAtlas(folder);
  const core::TriMesh mesh = ExtractMesh(opened, {});
  const auto view = opened.View();
  const core::Box3 room{Vec3(-2, -2, 0), Vec3(2, 2, 2.4)};
  const Pose T_map_newest = opened.submaps[0].T_map_submap;
  size_t of_older = 0, of_newest = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3 middle =
        ((mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3.0f).cast<double>();
    const auto to_walls = [&](const Vec3& p) {
      return std::min((p - room.min).cwiseAbs().minCoeff(), (p - room.max).cwiseAbs().minCoeff());
    };
    const bool newest = to_walls(T_map_newest.inverse() * middle) < to_walls(middle);
    ++(newest ? of_newest : of_older);
    if (!newest && to_walls(T_map_newest.inverse() * middle) > 0.3) {
      EXPECT_NE(view->RightAbout(middle), 0u) << middle.transpose();
    }
  }
  EXPECT_GT(of_newest, 1000u);
  EXPECT_GT(of_older, 100u);
  const size_t alone = ExtractMesh(opened.submaps[0].contents->Get()->tree, {}).triangles.size() +
                       ExtractMesh(opened.submaps[1].contents->Get()->tree, {}).triangles.size();
  EXPECT_LT(mesh.triangles.size(), alone);
}

TEST_F(SavedAtlasTest, OnOneLatticeTheNewestIsRight) {
  const SavedAtlas opened = LoadAtlas(folder);
  const OccupancyOctree lattice = OnOneLattice(opened);
  const auto view = opened.View();
  core::Rng rng(2);
  size_t known = 0, like = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vec3 p(rng.Uniform(-2.0, 2.6), rng.Uniform(-2.0, 2.2), rng.Uniform(0.0, 2.4));
    const Vec3 middle = lattice.CenterOf(lattice.KeyAt(p));
    const CellState state = view->StateAt(middle);
    if (state == CellState::kUnknown) continue;
    ++known;
    like += (lattice.At(middle) > 0) == (state == CellState::kOccupied);
  }
  EXPECT_GT(known, 1000u);
  EXPECT_GT(static_cast<double>(like), 0.97 * static_cast<double>(known));
}

}  // namespace
}  // namespace atlas::tests
