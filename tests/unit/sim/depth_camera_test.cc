#include "sim/sensors/depth_camera.h"

#include <gtest/gtest.h>

#include <thread>

#include "sim/sensors/raycaster.h"
#include "tests/support/sensor_scenes.h"

namespace atlas::sim {
namespace {

using namespace testing;  // NOLINT

DepthCameraModel ExactCamera() {
  DepthCameraModel model;
  model.sigma_per_m2 = 0.0;
  return model;
}

/// Camera at `p`, looking along +x of the map, pitched down.
core::Pose CameraAt(const core::Vec3& p, double pitch_down_rad) {
  core::Mat3 R_base_camera;
  R_base_camera << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return core::MakePose(core::RotationFromYawPitchRoll(0.0, pitch_down_rad, 0.0) * R_base_camera, p);
}

/// The ray through pixel (u, v), scaled so that its depth is 1.
core::Vec3 PixelRay(const core::DepthImage& image, int u, int v) {
  return {(u + 0.5 - 0.5 * image.width) / image.focal_px, (v + 0.5 - 0.5 * image.height) / image.focal_px,
          1.0};
}

float DepthAt(const core::DepthImage& image, int u, int v) {
  return image.depth_m[static_cast<size_t>(v * image.width + u)];
}

scenes::SceneSpec KerbAndSteps() {
  return Scene(
      {Part(BoxMesh({20, 20, 0.5}, At(0, 0, -0.5))), Part(BoxMesh({0.15, 1.5, 0.075}, At(1.2, 0, 0.075))),
       Part(BoxMesh({0.15, 1.5, 0.15}, At(1.5, 0, 0.15))), Part(BoxMesh({0.1, 0.1, 0.4}, At(1.0, 0.6, 0.4))),
       Part(SphereMesh(0.3, 64, At(1.4, -0.8, 0.3)))});
}

TEST(DepthCameraTest, DepthEqualsRaysThroughPixelCentres) {
  const scenes::SceneSpec scene = KerbAndSteps();
  DepthCamera camera(scene, ExactCamera(), core::Rng(1));
  ASSERT_TRUE(camera.available()) << camera.why_unavailable();
  const Raycaster raycaster(scene);
  core::Rng rng(1);
  size_t near = 0, compared = 0, holes_differ = 0, pixels = 0;
  for (int view = 0; view < 5; ++view) {
    core::Pose T_map_camera = CameraAt({rng.Uniform(-0.5, 0.3), rng.Uniform(-0.5, 0.5), 0.55}, 0.6);
    T_map_camera = T_map_camera * Eigen::AngleAxisd(rng.Uniform(-0.5, 0.5), core::Vec3::UnitZ());
    const core::DepthImage image = camera.Capture(T_map_camera);
    std::vector<core::Ray> rays;
    std::vector<double> depth_per_range;
    for (int v = 0; v < image.height; ++v) {
      for (int u = 0; u < image.width; ++u) {
        const core::Vec3 ray = PixelRay(image, u, v);
        depth_per_range.push_back(1.0 / ray.norm());
        rays.push_back({T_map_camera.translation().cast<float>(),
                        (T_map_camera.linear() * ray.normalized()).cast<float>()});
      }
    }
    std::vector<RayHit> hits(rays.size());
    raycaster.CastStatic(rays, 50.0f, 1, hits);
    for (size_t i = 0; i < rays.size(); ++i) {
      const double z = hits[i].range_m * depth_per_range[i];
      const bool measurable = z >= 0.2 && z <= 3.0;
      ++pixels;
      if (measurable == std::isnan(image.depth_m[i])) {
        ++holes_differ;
      } else if (measurable) {
        ++compared;
        near += std::abs(image.depth_m[i] - z) < 0.01 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(compared, pixels / 3);
  EXPECT_GE(static_cast<double>(near), 0.99 * static_cast<double>(compared));
  EXPECT_LE(static_cast<double>(holes_differ), 0.01 * static_cast<double>(pixels));
}

TEST(DepthCameraTest, NothingIsMeasuredTooNearTooFarOrInTheSky) {
  DepthCamera camera(Scene({Part(BoxMesh({0.5, 50, 50}, At(5.5, 0, 0)))}), ExactCamera(), core::Rng(1));
  ASSERT_TRUE(camera.available());
  const auto middle = [&](double x) { return DepthAt(camera.Capture(CameraAt({x, 0, 0}, 0.0)), 106, 60); };
  EXPECT_NEAR(middle(3.0), 2.0, 1e-4);
  EXPECT_NEAR(middle(2.001), 2.999, 1e-4);
  EXPECT_NEAR(middle(4.795), 0.205, 1e-4);
  EXPECT_TRUE(std::isnan(middle(1.99)));
  EXPECT_TRUE(std::isnan(middle(4.81)));
  EXPECT_TRUE(std::isnan(middle(8.0)));
}

TEST(DepthCameraTest, FirstRowIsTheTopAndFirstColumnTheLeft) {
  DepthCamera camera(Scene({Part(BoxMesh({0.5, 1, 1}, At(2, 1.0, 1.0)))}), ExactCamera(), core::Rng(1));
  ASSERT_TRUE(camera.available());
  const core::DepthImage image = camera.Capture(CameraAt({0, 0, 0}, 0.0));
  EXPECT_NEAR(DepthAt(image, 53, 30), 1.5, 1e-4);  // up and left of the centre: +z and +y
  EXPECT_TRUE(std::isnan(DepthAt(image, 159, 30)));
  EXPECT_TRUE(std::isnan(DepthAt(image, 53, 90)));
}

TEST(DepthCameraTest, TheRobotsOwnBodiesHideTheSceneAndAreNotMeasured) {
  DepthCamera camera(Scene({Part(BoxMesh({0.5, 50, 50}, At(3, 0, 0)))}), ExactCamera(), core::Rng(1));
  ASSERT_TRUE(camera.available());
  EXPECT_EQ(camera.AddBody(BoxMesh({0.1, 0.1, 0.1})), 0);
  EXPECT_EQ(camera.AddBody(BoxMesh({0.1, 0.1, 0.1})), 1);
  camera.SetBodyPose(0, At(1.0, 0, 0));
  camera.SetBodyPose(1, At(1.0, 0.7, 0));
  const core::DepthImage image = camera.Capture(CameraAt({0, 0, 0}, 0.0));
  EXPECT_TRUE(std::isnan(DepthAt(image, 106, 60)));
  EXPECT_NEAR(DepthAt(image, 150, 60), 2.5, 1e-4);
  EXPECT_TRUE(std::isnan(DepthAt(image, 106 - static_cast<int>(0.7 / 0.9 * image.focal_px), 60)));
  camera.SetBodyPose(0, At(3.0, 0, 0));  // inside the wall
  EXPECT_NEAR(DepthAt(camera.Capture(CameraAt({0, 0, 0}, 0.0)), 106, 60), 2.5, 1e-4);
}

TEST(DepthCameraTest, NoiseGrowsWithDepthSquaredAndRepeatsWithTheSeed) {
  const scenes::SceneSpec wall = Scene({Part(BoxMesh({0.5, 50, 50}, At(5.5, 0, 0)))});
  DepthCamera camera(wall, {}, core::Rng(1)), again(wall, {}, core::Rng(1));
  ASSERT_TRUE(camera.available());
  for (const double z : {1.0, 2.0, 2.9}) {
    const core::Pose T_map_camera = CameraAt({5.0 - z, 0, 0}, 0.0);
    const core::DepthImage image = camera.Capture(T_map_camera);
    double sum2 = 0.0;
    for (const float depth : image.depth_m) sum2 += (depth - z) * (depth - z);
    EXPECT_NEAR(std::sqrt(sum2 / static_cast<double>(image.depth_m.size())), 0.002 * z * z, 0.0001 * z * z);
    EXPECT_EQ(image.depth_m, again.Capture(T_map_camera).depth_m);
  }
}

TEST(DepthCameraTest, AnotherThreadMayCapture) {
  DepthCamera camera(KerbAndSteps(), ExactCamera(), core::Rng(1));
  ASSERT_TRUE(camera.available());
  const core::Pose T_map_camera = CameraAt({0, 0, 0.5}, 0.6);
  const core::DepthImage here = camera.Capture(T_map_camera);
  core::DepthImage there;
  std::thread([&] { there = camera.Capture(T_map_camera); }).join();
  ASSERT_EQ(here.depth_m.size(), there.depth_m.size());
  for (size_t i = 0; i < here.depth_m.size(); ++i) {
    ASSERT_TRUE(here.depth_m[i] == there.depth_m[i] || std::isnan(here.depth_m[i]));
  }
}

}  // namespace
}  // namespace atlas::sim
