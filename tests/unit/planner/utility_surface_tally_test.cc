// Progress as the planner sees it: only the object's surface, each voxel once.
#include "planner/stopping/surface_tally.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

namespace atlas::planner {
namespace {

using core::Vec3f;

/// One floor, or two above one another.
class LevelGround : public mapping::TraversableGround {
 public:
  explicit LevelGround(double height_m, std::optional<double> upper_m = std::nullopt)
      : height_m_(height_m), upper_m_(upper_m) {}
  Levels LevelsAt(const core::Vec2&) const override {
    Levels levels;
    levels.Add(height_m_);
    if (upper_m_) levels.Add(*upper_m_);
    return levels;
  }
  double Traversability(const core::Vec3&) const override { return 1.0; }
  mapping::GroundKind KindAt(const core::Vec3&) const override { return mapping::GroundKind::kFree; }
  bool FootprintFree(const core::Vec3&, double) const override { return true; }
  bool CircleFree(const core::Vec3&) const override { return true; }
  Surface SurfaceAt(const core::Vec3& p) const override {
    Surface surface;
    surface.height_m = upper_m_ && std::abs(p.z() - *upper_m_) <= kSameLevel_m ? *upper_m_ : height_m_;
    return surface;
  }
  core::Box3 Window() const override { return {{-9, -9, -9}, {9, 9, 9}}; }

 private:
  double height_m_;
  std::optional<double> upper_m_;
};

const core::Box3 kBox{{-1.0, -1.0, 0.0}, {1.0, 1.0, 2.0}};

TEST(SurfaceTally, AVoxelCountsOnceHoweverOftenItComesAndGoes) {
  SurfaceTally tally(kBox, 0.05);
  const LevelGround ground(0.0);
  const std::vector<Vec3f> two = {{0.025f, 0.025f, 1.025f}, {0.075f, 0.025f, 1.025f}};
  EXPECT_EQ(tally.CountNew(two, ground), 2u);
  EXPECT_EQ(tally.CountNew({}, ground), 0u);
  EXPECT_EQ(tally.CountNew(two, ground), 0u);
  EXPECT_EQ(tally.CountNew({two[1], {0.175f, 0.025f, 1.025f}}, ground), 1u);
}

TEST(SurfaceTally, ManyReturnsInAVoxelAreOne) {
  SurfaceTally tally(kBox, 0.05);
  const LevelGround ground(0.0);
  EXPECT_EQ(tally.CountNew({{0.011f, 0.02f, 1.03f}, {0.012f, 0.04f, 1.02f}, {0.031f, 0.01f, 1.01f}}, ground),
            1u);
}

TEST(SurfaceTally, ASurfaceThatNoiseThickensIsNotNew) {
  SurfaceTally tally(kBox, 0.05);
  const LevelGround ground(0.0);
  std::vector<Vec3f> wall, thicker;
  for (int i = 0; i < 20; ++i) {
    for (int k = 0; k < 20; ++k) {
      wall.emplace_back(-0.475f + 0.05f * static_cast<float>(i), 0.025f,
                        0.525f + 0.05f * static_cast<float>(k));
      thicker.emplace_back(wall.back() + Vec3f(0.0f, 0.05f, 0.0f));
    }
  }
  EXPECT_EQ(tally.CountNew(wall, ground), 400u);
  EXPECT_EQ(tally.CountNew(thicker, ground), 0u);
}

TEST(SurfaceTally, GroundAndSurroundingsDoNotCount) {
  SurfaceTally tally(kBox, 0.05);
  const std::vector<Vec3f> voxels = {{0.025f, 0.025f, 0.325f},   // on the ground
                                     {0.025f, 0.025f, 0.425f},   // a low part
                                     {1.525f, 0.025f, 1.025f},   // beside the box
                                     {0.025f, 0.025f, 2.075f}};  // above it
  EXPECT_EQ(tally.CountNew(voxels, LevelGround(0.3)), 1u);
}

/// A post through both storeys, a voxel a height; the upper floor cuts it at 3 m.
TEST(SurfaceTally, OfAWallUnderAnUpperFloorOnlyWhatIsAtTheFloorsIsGround) {
  const core::Box3 house{{-1.0, -1.0, 0.0}, {1.0, 1.0, 5.0}};
  const LevelGround storeys(0.0, 3.0);
  for (int k = 0; k < 100; ++k) {
    const double z = 0.025 + 0.05 * k;
    SurfaceTally tally(house, 0.05);
    const bool at_a_floor = z < 0.1 || std::abs(z - 3.0) < 0.1;
    EXPECT_EQ(tally.CountNew({Vec3f(0.025f, 0.025f, static_cast<float>(z))}, storeys), at_a_floor ? 0u : 1u)
        << z;
  }
}

TEST(SurfaceTally, EveryVoxelOfTheBoxHasItsOwnPlace) {
  SurfaceTally tally(kBox, 0.05);
  std::vector<Vec3f> all;
  for (int k = 0; k < 40; ++k) {
    for (int j = 0; j < 40; ++j) {
      for (int i = 0; i < 40; ++i) {
        all.emplace_back(-0.975f + 0.05f * static_cast<float>(i), -0.975f + 0.05f * static_cast<float>(j),
                         0.025f + 0.05f * static_cast<float>(k));
      }
    }
  }
  EXPECT_EQ(tally.CountNew(all, LevelGround(-1.0)), 64000u);
  EXPECT_EQ(tally.CountNew(all, LevelGround(-1.0)), 0u);
}

}  // namespace
}  // namespace atlas::planner
