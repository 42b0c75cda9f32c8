#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>

#include "core/errors.h"
#include "core/files.h"
#include "core/geometry.h"
#include "core/lidar_model.h"
#include "core/mesh.h"
#include "core/parallel_for.h"
#include "core/rng.h"
#include "core/sensor_events.h"

namespace atlas::core {
namespace {

TEST(Box3, ClipMatchesDenseSampling) {
  Rng rng(1);
  const Box3 box{Vec3(-1, -2, 0), Vec3(2, 1, 1.5)};
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3 origin(rng.Uniform(-4, 4), rng.Uniform(-4, 4), rng.Uniform(-3, 4));
    const Vec3 direction = Vec3(rng.Normal(), rng.Normal(), rng.Normal()).normalized();
    const auto span = box.Clip(origin, direction);
    for (double t = 0.0; t < 12.0; t += 0.01) {
      const bool inside = box.Contains(origin + t * direction);
      const bool predicted = span && t >= span->first && t <= span->second;
      if (inside != predicted) {
        ASSERT_TRUE(span) << trial;
        ASSERT_LT(std::min(std::abs(t - span->first), std::abs(t - span->second)), 1e-9);
      }
    }
  }
}

TEST(Rng, NormalHasUnitMomentsAndStreamsAreIndependent) {
  Rng rng(7);
  double sum = 0, squares = 0, product = 0;
  Rng a = rng.Split("a"), b = rng.Split("b");
  constexpr int kCount = 200000;
  for (int i = 0; i < kCount; ++i) {
    const double x = NormalAt(11, static_cast<uint64_t>(i));
    sum += x;
    squares += x * x;
    product += a.Normal() * b.Normal();
  }
  EXPECT_NEAR(sum / kCount, 0.0, 0.01);
  EXPECT_NEAR(squares / kCount, 1.0, 0.02);
  EXPECT_NEAR(product / kCount, 0.0, 0.01);
  EXPECT_EQ(Rng(7).Split("a").Next(), Rng(7).Split("a").Next());
}

TEST(PoseTrajectory, InterpolatesBetweenAndClampsOutside) {
  PoseTrajectory trajectory;
  trajectory.Add(1.0, PoseFromXyzYaw(Vec3(0, 0, 0), 0.0));
  trajectory.Add(2.0, PoseFromXyzYaw(Vec3(2, 0, 0), kPi / 2));
  const Pose T = trajectory.At(1.25);
  EXPECT_NEAR(T.translation().x(), 0.5, 1e-12);
  EXPECT_NEAR(YawOf(T.linear()), kPi / 8, 1e-12);
  EXPECT_NEAR(trajectory.At(0.0).translation().x(), 0.0, 1e-12);
  EXPECT_NEAR(trajectory.At(9.0).translation().x(), 2.0, 1e-12);
}

TEST(ParallelFor, CoversEachIndexOnceAndPassesExceptionsOn) {
  for (const int threads : {1, 2, 5}) {
    std::vector<std::atomic<int>> seen(1003);
    ParallelFor(threads, seen.size(), [&](size_t begin, size_t end, size_t) {
      for (size_t i = begin; i < end; ++i) ++seen[i];
    });
    for (const auto& count : seen) EXPECT_EQ(count, 1);
    EXPECT_THROW(ParallelFor(threads, 10, [](size_t, size_t, size_t) { throw InputError("x"); }), InputError);
  }
}

TEST(UnknownName, SuggestsTheNearOne) {
  const std::string message =
      UnknownName("gain", "occlusion_awere", {"occlusion_aware", "rear_side_entropy"});
  EXPECT_NE(message.find("did you mean 'occlusion_aware'"), std::string::npos);
  EXPECT_EQ(NearestName("zzzzzz", {"occlusion_aware"}), "");
}

TEST(LidarModel, BeamsMatchTheDataSheets) {
  const LidarModel vlp = FindLidarModel("vlp16");
  ASSERT_EQ(vlp.rows(), 16);
  EXPECT_NEAR(Degrees(vlp.elevation_rad.front() - vlp.elevation_rad.back()), 30.0, 1e-9);
  EXPECT_NEAR(Degrees(vlp.elevation_rad[0] - vlp.elevation_rad[1]), 2.0, 1e-9);
  for (const std::string& name : LidarModelNames()) {
    const LidarModel model = FindLidarModel(name);
    EXPECT_EQ(model.azimuth_offset_rad.size(), model.elevation_rad.size());
    EXPECT_LT(model.min_range_m, model.max_range_m);
  }
  EXPECT_THROW(FindLidarModel("vlp-16"), InputError);
}

TEST(TriMesh, AreaOfATransformedUnitSquareIsOne) {
  TriMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.Transform(MakePose(RotationFromYawPitchRoll(0.3, 0.8, -1.0), Vec3(4, 5, 6)));
  EXPECT_NEAR(mesh.AreaM2(), 1.0, 1e-5);
  TriMesh both = mesh;
  both.Append(mesh);
  EXPECT_EQ(both.triangles[2][0], 4u);
}

}  // namespace
}  // namespace atlas::core
