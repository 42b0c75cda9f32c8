#include <gtest/gtest.h>

#include "core/errors.h"
#include "core/rng.h"
#include "locomotion_scenes.h"
#include "walking_robot.h"

namespace atlas::sim {
namespace {

using core::Vec2;
using core::Vec3;

scenes::ScenePart SolidPart(const scenes::CollisionShape& shape) {
  scenes::ScenePart part;
  part.name = "part";
  part.collision.push_back(shape);
  return part;
}

/// A smooth hill sampled every 10 cm over 8 m x 6 m.
double HillHeight(double x, double y) {
  return 0.15 * std::sin(0.9 * x) * std::cos(0.8 * y) - 0.05;
}

scenes::SceneSpec HillScene() {
  scenes::HeightGridShape grid;
  grid.cols = 81;
  grid.rows = 61;
  grid.spacing_m = 0.1;
  grid.origin = Vec2(-1.0, -3.0);
  for (int r = 0; r < grid.rows; ++r) {
    for (int c = 0; c < grid.cols; ++c) {
      const Vec2 p = grid.origin + grid.spacing_m * Vec2(c, r);
      grid.height_m.push_back(static_cast<float>(HillHeight(p.x(), p.y())));
    }
  }
  scenes::SceneSpec scene;
  scene.name = "hill";
  scene.parts.push_back(SolidPart({grid, core::Pose::Identity()}));
  scene.T_map_spawn = core::PoseFromXyzYaw({0.5, 0.0, HillHeight(0.5, 0.0)}, 0.0);
  return scene;
}

TEST(World, GroundBelowAHeightGridIsItsSampledSurface) {
  const World world(HillScene(), robots::LoadRobot("quadruped"));
  core::Rng rng(2);
  for (int i = 0; i < 500; ++i) {
    const double x = rng.Uniform(-0.9, 6.9), y = rng.Uniform(-2.9, 2.9);
    const auto z = world.GroundBelow({x, y, 2.0});
    ASSERT_TRUE(z.has_value());
    EXPECT_NEAR(*z, HillHeight(x, y), 0.002);  // 10 cm chords of this hill sag by a millimetre
  }
  EXPECT_FALSE(world.GroundBelow({-1.5, 0.0, 2.0}).has_value());
}

TEST(World, GroundBelowEveryShapeIsItsUpperSide) {
  scenes::SceneSpec scene = test::FlatScene();
  scenes::HullShape wedge;  // top falls from z = 0.5 at x = 0 to 0 at x = 1
  for (const double y : {-0.5, 0.5}) {
    for (const Vec3& p : {Vec3(0, y, -0.2), Vec3(0, y, 0.5), Vec3(1, y, 0.0), Vec3(1, y, -0.2)}) {
      wedge.mesh.vertices.push_back(p.cast<float>());
    }
  }
  scene.parts.push_back(SolidPart({wedge, test::At(10.0, 0.0, 0.0)}));
  scene.parts.push_back(SolidPart({scenes::CylinderShape{0.4, 0.3}, test::At(-3.0, 0.0, 0.3)}));
  scene.parts.push_back(SolidPart({scenes::SphereShape{0.5}, test::At(-6.0, 0.0, 0.0)}));
  scene.parts.push_back(SolidPart({scenes::CapsuleShape{0.2, 0.5}, test::At(-9.0, 0.0, 0.0)}));
  scene.parts.push_back(SolidPart({scenes::BoxShape{{0.5, 0.5, 0.1}}, test::At(5.0, 5.0, 3.0)}));  // overhead
  const World world(scene, robots::LoadRobot("quadruped"));
  EXPECT_NEAR(*world.GroundBelow({10.25, 0.1, 2.0}), 0.375, 1e-6);
  EXPECT_NEAR(*world.GroundBelow({-3.1, 0.1, 2.0}), 0.6, 1e-6);
  EXPECT_NEAR(*world.GroundBelow({-6.3, 0.0, 2.0}), 0.4, 1e-6);
  EXPECT_NEAR(*world.GroundBelow({-9.0, 0.0, 2.0}), 0.7, 1e-6);
  EXPECT_NEAR(*world.GroundBelow({5.0, 5.0, 1.0}), 0.0, 1e-6);
  EXPECT_NEAR(*world.GroundBelow({5.0, 5.0, 4.0}), 3.1, 1e-6);
  EXPECT_NEAR(*world.GroundBelow({-3.0, 0.0, 0.3}), 0.3, 1e-6)
      << "a point inside a solid is obstructed at once";
}

TEST(World, RobotWalksOverAHeightGrid) {
  test::WalkingRobot robot(HillScene());
  ASSERT_TRUE(robot.Run(1.0, {}));
  EXPECT_TRUE(robot.WalkTo(5.0, 0.4));
  EXPECT_NEAR(robot.world.state().p_base.z() - HillHeight(robot.world.state().p_base.x(), 0.0), 0.44, 0.06);
}

TEST(World, CullingDistantShapesChangesNothing) {
  // The same walk with a crowd of distant boxes: none is touched, so not a bit may differ.
  scenes::SceneSpec crowded = test::FlatScene();
  for (int i = 0; i < 100; ++i) {
    crowded.parts.push_back(
        test::BoxPart("box", {0.2, 0.2, 0.3}, test::At(0.6 * (i % 20) - 3.0, 6.0 + i / 20, 0.3)));
  }
  test::WalkingRobot alone(test::FlatScene()), among(crowded);
  ASSERT_TRUE(alone.Run(4.0, {0.5, 0.0, 0.2}));
  ASSERT_TRUE(among.Run(4.0, {0.5, 0.0, 0.2}));
  EXPECT_EQ(alone.world.qpos(), among.world.qpos());
}

TEST(World, ShapesThatPhysicsCannotTakeAreBadInput) {
  scenes::SceneSpec flat_hull = test::FlatScene();
  scenes::HullShape hull;
  hull.mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5f, 0.5f, 0}};
  flat_hull.parts.push_back(SolidPart({hull, core::Pose::Identity()}));
  EXPECT_THROW(World(flat_hull, robots::LoadRobot("quadruped")), core::InputError);

  scenes::SceneSpec short_grid = test::FlatScene();
  short_grid.parts.push_back(
      SolidPart({scenes::HeightGridShape{3, 3, 0.1, Vec2::Zero(), {0.0f}}, core::Pose::Identity()}));
  EXPECT_THROW(World(short_grid, robots::LoadRobot("quadruped")), core::InputError);
  scenes::SceneSpec no_size = test::FlatScene();
  no_size.parts.push_back(SolidPart({scenes::BoxShape{Vec3(1.0, 1.0, 0.0)}, core::Pose::Identity()}));
  EXPECT_THROW(World(no_size, robots::LoadRobot("quadruped")), core::InputError);
}

TEST(World, BodiesOfTheRobotAreMeshedWithoutTheLidarAroundItsOwnRays) {
  const robots::RobotSpec robot = robots::LoadRobot("quadruped");
  World world(test::FlatScene(), robot);
  ASSERT_EQ(world.body_meshes().size(), 13u);
  const Vec3 p_lidar = robot.T_base_lidar.translation();
  for (const core::Vec3f& v : world.body_meshes()[0].vertices) {
    EXPECT_GT((v.cast<double>() - p_lidar).norm(), 0.04);
  }
  std::vector<core::Pose> poses;
  world.Place(core::PoseFromXyzYaw({1.0, 2.0, 0.5}, 0.3), Vec12::Zero());
  world.BodyPoses(&poses);
  EXPECT_LT((poses[0].translation() - Vec3(1.0, 2.0, 0.5)).norm(), 1e-12);
}

}  // namespace
}  // namespace atlas::sim
