#include <gtest/gtest.h>

#include <cstdlib>

#include "sim/render/scene_renderer.h"
#include "tests/support/sensor_scenes.h"

namespace atlas::sim {
namespace {

using namespace testing;  // NOLINT

constexpr Rgb kRed = {200, 40, 30}, kGreen = {30, 180, 60}, kGrey = {150, 150, 150};

Rgb PixelAt(const RgbImage& image, int u, int v) {
  const auto i = 3 * static_cast<size_t>(v * image.width + u);
  return {image.rgb[i], image.rgb[i + 1], image.rgb[i + 2]};
}
int Brightness(const Rgb& rgb) {
  return rgb[0] + rgb[1] + rgb[2];
}

TEST(RenderContextTest, TwoContextsLiveSideBySideAndAfterOneAnother) {
  for (int round = 0; round < 3; ++round) {
    const RenderContext::Made first = RenderContext::Make(), second = RenderContext::Make();
    ASSERT_TRUE(first.context) << first.why_not;
    ASSERT_TRUE(second.context) << second.why_not;
    SceneRenderer a(first.context), b(second.context);
    a.AddMesh({BoxMesh({0.5, 0.5, 0.5}, At(0, 0, 3)), {kRed}});
    b.AddMesh({BoxMesh({0.5, 0.5, 0.5}, At(0, 0, 5)), {kRed}});
    for (int frame = 0; frame < 2; ++frame) {
      EXPECT_NEAR(a.RenderDepth({}, 9, 9)[40], 2.5f, 1e-4);
      EXPECT_NEAR(b.RenderDepth({}, 9, 9)[40], 4.5f, 1e-4);
    }
  }
}

/// Ends the process with 0 where OSMesa draws a box right.
[[noreturn]] void DrawWithOsMesa() {
  const RenderContext::Made made = RenderContext::Make(RenderBackend::kOsMesa);
  if (!made.context || made.context->backend() != "osmesa") std::_Exit(1);
  SceneRenderer renderer(made.context);
  renderer.AddMesh({BoxMesh({0.5, 0.5, 0.5}, At(0, 0, 3)), {kRed}});
  const std::vector<float> depth = renderer.RenderDepth({}, 9, 9);
  std::_Exit(std::abs(depth[40] - 2.5f) < 1e-4f && std::isinf(depth[0]) ? 0 : 2);
}

TEST(RenderContextDeathTest, OsMesaDrawsInAProcessOfItsOwn) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(DrawWithOsMesa(), ::testing::ExitedWithCode(0), "");
}

class RenderSceneTest : public ::testing::Test {
 protected:
  void SetUp() override {
    RenderContext::Made made = RenderContext::Make();
    ASSERT_TRUE(made.context) << made.why_not;
    renderer_ = std::make_unique<SceneRenderer>(made.context);
  }
  std::unique_ptr<SceneRenderer> renderer_;
};

TEST_F(RenderSceneTest, PictureHasTopRowFirstAndColoursInPlace) {
  renderer_->AddMesh({BoxMesh({0.1, 1, 1}, At(5, 1.0, 1.0)), {kRed}});      // left, up
  renderer_->AddMesh({BoxMesh({0.1, 1, 1}, At(5, -1.0, -1.0)), {kGreen}});  // right, down
  RenderCamera camera;
  camera.T_map_camera = LookAt({0, 0, 0}, {1, 0, 0});
  const RgbImage image = renderer_->RenderRgb(camera, {}, 80, 60);
  EXPECT_GT(PixelAt(image, 30, 20)[0], 2 * PixelAt(image, 30, 20)[1]);
  EXPECT_GT(PixelAt(image, 50, 40)[1], 2 * PixelAt(image, 50, 40)[0]);
  EXPECT_EQ(PixelAt(image, 2, 2), RenderLight{}.sky);
  EXPECT_EQ(PixelAt(image, 50, 20), RenderLight{}.sky);
}

TEST_F(RenderSceneTest, PosesMoveHidingHidesAndReplacingReplaces) {
  const int box = renderer_->AddMesh({BoxMesh({0.5, 0.5, 0.5}), {kRed}});
  const auto middle = [&] { return renderer_->RenderDepth({}, 9, 9)[40]; };
  renderer_->SetPose(box, At(0, 0, 3));
  EXPECT_NEAR(middle(), 2.5f, 1e-4);
  renderer_->SetPose(box, At(0, 0, 4));
  EXPECT_NEAR(middle(), 3.5f, 1e-4);
  renderer_->SetVisible(box, false);
  EXPECT_TRUE(std::isinf(middle()));
  renderer_->SetVisible(box, true);
  renderer_->ReplaceMesh(box, {BoxMesh({0.5, 0.5, 1.0}), {kRed}});
  EXPECT_NEAR(middle(), 3.0f, 1e-4);
  renderer_->ReplaceMesh(box, {{}, {kRed}});
  EXPECT_TRUE(std::isinf(middle()));
}

TEST_F(RenderSceneTest, ManyChunksAreAllDrawn) {
  core::Rng rng(1);
  core::TriMesh field;  // a floor of 120 x 120 tiles, far more than a chunk
  for (int i = 0; i < 120 * 120; ++i) {
    field.Append(BoxMesh({0.05, 0.05, 0.01}, At(0.1 * (i % 120) - 5.95, 0.1 * (i / 120) - 5.95, -0.01)));
  }
  renderer_->AddMesh({field, {kGrey}});
  for (int view = 0; view < 20; ++view) {
    RenderCamera camera;
    const core::Vec3 eye(rng.Uniform(-3, 3), rng.Uniform(-3, 3), rng.Uniform(0.5, 2.0));
    camera.T_map_camera = LookAt(eye, eye + core::Vec3(rng.Normal(), rng.Normal(), -1.5));
    constexpr int kWidth = 64, kHeight = 48;
    const std::vector<float> depth = renderer_->RenderDepth(camera, kWidth, kHeight);
    const double focal = 0.5 * kHeight / std::tan(0.5 * camera.vertical_fov_rad);
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        const core::Vec3 ray =
            camera.T_map_camera.linear() *
            core::Vec3((u + 0.5 - kWidth / 2) / focal, (v + 0.5 - kHeight / 2) / focal, 1.0);
        const double z = -eye.z() / ray.z();
        const core::Vec3 p = eye + z * ray;
        if (ray.z() > -1e-3 || p.cwiseAbs().head<2>().maxCoeff() > 5.9) continue;
        ASSERT_NEAR(depth[static_cast<size_t>(v * kWidth + u)], z, 0.002 * z) << u << " " << v;
      }
    }
  }
}

TEST_F(RenderSceneTest, ShadowsFallWhereTheSunIsHidden) {
  renderer_->AddMesh({BoxMesh({10, 10, 0.1}, At(0, 0, -0.1)), {kGrey}});
  renderer_->AddMesh({BoxMesh({0.5, 0.5, 0.02}, At(0, 0, 1.0)), {kGrey}});
  RenderCamera camera;
  camera.T_map_camera = LookAt({3, 0, 0.6}, {0, 0, 0});
  RenderLight light;
  light.to_sun = core::Vec3(0.01, 0, 1);
  const int lit = Brightness(PixelAt(renderer_->RenderRgb(camera, light, 80, 60), 40, 30));
  light.shadow_radius_m = 3.0;
  const RgbImage image = renderer_->RenderRgb(camera, light, 80, 60);
  EXPECT_LT(Brightness(PixelAt(image, 40, 30)), 0.75 * lit);
  EXPECT_NEAR(Brightness(PixelAt(image, 40, 55)), lit, 0.1 * lit);  // nearer the camera, in the sun
}

TEST_F(RenderSceneTest, MoreSamplesSmoothEdges) {
  renderer_->AddMesh(
      {BoxMesh({0.1, 1, 1}, At(5, 0, 0) * Eigen::AngleAxisd(0.3, core::Vec3::UnitX())), {kRed}});
  RenderCamera camera;
  camera.T_map_camera = LookAt({0, 0, 0}, {1, 0, 0});
  const auto between = [&](int samples) {
    const RgbImage image = renderer_->RenderRgb(camera, {}, 160, 120, samples);
    const Rgb sky = PixelAt(image, 0, 0), box = PixelAt(image, 80, 60);
    int count = 0;
    for (int i = 0; i < 160 * 120; ++i) {
      const Rgb p = PixelAt(image, i % 160, i / 160);
      count += p[1] > box[1] + 20 && p[1] < sky[1] - 20 ? 1 : 0;
    }
    return count;
  };
  EXPECT_EQ(between(1), 0);
  EXPECT_GT(between(4), 50);
}

}  // namespace
}  // namespace atlas::sim
