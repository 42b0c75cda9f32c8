#include "experiments/judge/coverage.h"

#include <gtest/gtest.h>

#include <ctime>

#include "core/rng.h"
#include "experiments/judge/align.h"
#include "experiments/judge/point_grid.h"
#include "experiments/judge/scene_surface.h"
#include "mapping/slam/fixed_poses.h"

namespace atlas::experiments {
namespace {

using core::Box3;
using core::Pose;
using core::Vec3;
using core::Vec3f;

std::vector<Vec3f> RandomPoints(size_t count, double size, core::Rng* rng) {
  std::vector<Vec3f> points(count);
  for (Vec3f& p : points) {
    p = Vec3(rng->Uniform(-size, size), rng->Uniform(-size, size), rng->Uniform(-size, size)).cast<float>();
  }
  return points;
}

/// Six faces of a box sampled on a regular grid, with outward normals.
scenes::GroundTruth SampledBox(const Vec3& half, double spacing) {
  scenes::GroundTruth truth;
  truth.part_names = {"x_faces", "y_faces", "z_faces"};
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const double sign : {-1.0, 1.0}) {
      for (double a = -half[u]; a <= half[u]; a += spacing) {
        for (double b = -half[v]; b <= half[v]; b += spacing) {
          Vec3 p;
          p[axis] = sign * half[axis];
          p[u] = a;
          p[v] = b;
          truth.points.push_back(p.cast<float>());
          truth.normals.push_back((sign * Vec3::Unit(axis)).cast<float>());
          truth.part.push_back(static_cast<uint16_t>(axis));
        }
      }
    }
  }
  return truth;
}

TEST(CoverageScorer, EqualsBruteForceAfterEveryCloud) {
  core::Rng rng(7);
  const std::vector<Vec3f> truth = RandomPoints(4000, 0.4, &rng);
  const float radius = 0.043f;
  CoverageScorer scorer(truth, radius);
  std::vector<uint8_t> expected(truth.size(), 0);
  for (int scan = 0; scan < 4; ++scan) {
    const core::PointCloud cloud{RandomPoints(300, 0.5, &rng)};
    scorer.AddCloud(cloud);
    for (size_t i = 0; i < truth.size(); ++i) {
      for (const Vec3f& p : cloud.points) expected[i] |= (truth[i] - p).squaredNorm() <= radius * radius;
    }
    EXPECT_EQ(scorer.covered(), expected);
    const double share = static_cast<double>(std::count(expected.begin(), expected.end(), 1)) / truth.size();
    EXPECT_DOUBLE_EQ(scorer.coverage_raw(), share);
  }
  scorer.Reset();
  EXPECT_EQ(scorer.coverage_raw(), 0.0);
}

TEST(CoverageScorer, MovedPointsScoreAsTheirImages) {
  core::Rng rng(9);
  const std::vector<Vec3f> truth = RandomPoints(3000, 0.4, &rng);
  const core::PointCloud cloud{RandomPoints(400, 0.4, &rng)};
  const Pose T = core::MakePose(core::RotationFromYawPitchRoll(0.3, -0.1, 0.2), Vec3(0.05, 0.02, -0.04));
  core::PointCloud moved;
  for (const Vec3f& p : cloud.points) {
    moved.points.push_back(T.linear().cast<float>() * p + T.translation().cast<float>());
  }
  CoverageScorer a(truth, 0.043), b(truth, 0.043);
  a.AddPoints(cloud.points, T);
  b.AddCloud(moved);
  EXPECT_EQ(a.covered(), b.covered());
  EXPECT_GT(a.covered_count(), 100u);
}

/// Truth with random normals, some of it two-sided.
scenes::GroundTruth RandomTruth(size_t count, core::Rng* rng) {
  scenes::GroundTruth truth;
  truth.points = RandomPoints(count, 0.4, rng);
  for (size_t i = 0; i < count; ++i) {
    truth.normals.push_back(Vec3(rng->Normal(), rng->Normal(), rng->Normal()).normalized().cast<float>());
    truth.two_sided.push_back(i % 5 == 0 ? 1 : 0);
  }
  return truth;
}

TEST(CoverageScorer, OfTheOuterSideEqualsBruteForceAfterEveryCloud) {
  core::Rng rng(17);
  const scenes::GroundTruth truth = RandomTruth(4000, &rng);
  const double radius = 0.043;
  CoverageScorer scorer(std::make_shared<PointGrid>(truth.points, 2.0 * radius), truth, radius);
  const Pose T = core::MakePose(core::RotationFromYawPitchRoll(0.3, -0.1, 0.2), Vec3(0.05, 0.02, -0.04));
  std::vector<uint8_t> expected(truth.points.size(), 0);
  for (int scan = 0; scan < 3; ++scan) {
    const std::vector<Vec3f> points = RandomPoints(300, 0.5, &rng), origins = RandomPoints(300, 3.0, &rng);
    scorer.AddReturns(points, origins, T);
    for (size_t i = 0; i < expected.size(); ++i) {
      const Vec3 q = truth.points[i].cast<double>(), n = truth.normals[i].cast<double>();
      for (size_t k = 0; k < points.size(); ++k) {
        const Vec3 p = T * points[k].cast<double>(), o = T * origins[k].cast<double>();
        const bool outer = truth.two_sided[i] != 0 || n.dot(o - q) > 0.0;
        if ((p - q).norm() <= radius && outer) expected[i] = 1;
      }
    }
    size_t differ = 0;  // rounding at the radius
    for (size_t i = 0; i < expected.size(); ++i) differ += expected[i] != scorer.covered()[i];
    EXPECT_LE(differ, 1u);
    EXPECT_GT(scorer.covered_count(), 100u);
  }
}

/// Level and tilted plates, seen from all sides: whole groups of points look away from most sensors.
TEST(CoverageScorer, OfTheOuterSideOfFlatFacesEqualsBruteForce) {
  core::Rng rng(23);
  const double radius = 0.043;
  for (const double tilt : {0.0, 0.4, 0.8}) {
    scenes::GroundTruth truth = SampledBox({0.3, 0.2, 0.01}, 0.012);
    const Eigen::Matrix3f R = core::RotationFromYawPitchRoll(0.2, tilt, 0.5 * tilt).cast<float>();
    for (Vec3f& p : truth.points) p = R * p;
    for (Vec3f& n : truth.normals) n = R * n;
    CoverageScorer scorer(std::make_shared<PointGrid>(truth.points, 2.0 * radius), truth, radius);
    const std::vector<Vec3f> points = RandomPoints(60, 0.3, &rng), origins = RandomPoints(60, 1.5, &rng);
    scorer.AddReturns(points, origins, Pose::Identity());
    std::vector<uint8_t> expected(truth.points.size(), 0);
    for (size_t i = 0; i < expected.size(); ++i) {
      const Vec3 q = truth.points[i].cast<double>(), n = truth.normals[i].cast<double>();
      for (size_t k = 0; k < points.size(); ++k) {
        const Vec3 p = points[k].cast<double>(), o = origins[k].cast<double>();
        if ((p - q).norm() <= radius && n.dot(o - q) > 0.0) expected[i] = 1;
      }
    }
    size_t differ = 0;  // rounding at the radius
    for (size_t i = 0; i < expected.size(); ++i) differ += expected[i] != scorer.covered()[i];
    EXPECT_LE(differ, 1u) << tilt;
    EXPECT_GT(scorer.covered_count(), 100u);
    EXPECT_LT(scorer.covered_count(), truth.points.size() / 2);
  }
}

TEST(CoverageMeter, FarFaceOfAThinPlateIsCoveredByEq39AloneUntilItIsSeen) {
  // A plate of 2 cm, its upper face seen from above with 1 cm of noise.
  const scenes::GroundTruth truth = SampledBox({1.0, 0.5, 0.01}, 0.01);
  CoverageMeter meter(truth, {});
  core::Rng rng(3);
  mapping::ReturnCloud above, below;
  for (size_t i = 0; i < truth.points.size(); ++i) {
    const Vec3f noise(0.0f, 0.0f, static_cast<float>(0.01 * rng.Normal()));
    if (truth.normals[i].z() > 0.5f) above.Add(truth.points[i] + noise, Vec3f(0, 0, 3));
    if (truth.normals[i].z() < -0.5f) below.Add(truth.points[i] + noise, Vec3f(0, 0, -3));
  }
  meter.AddCloud(above);
  const double upper = CoverageByPart(truth, meter.covered_outer())[2].share();
  EXPECT_NEAR(upper, 0.5, 0.005);
  EXPECT_GT(CoverageByPart(truth, meter.covered())[2].share(), 0.99);
  meter.AddCloud(below);
  EXPECT_GT(CoverageByPart(truth, meter.covered_outer())[2].share(), 0.99);
}

TEST(CoverageScorer, NothingCoversNothing) {
  CoverageScorer no_truth(std::vector<Vec3f>{}, 0.043);
  no_truth.AddCloud({{Vec3f::Zero()}});
  EXPECT_EQ(no_truth.coverage_raw(), 0.0);
  CoverageScorer no_cloud(std::vector<Vec3f>{Vec3f::Zero()}, 0.043);
  no_cloud.AddCloud({});
  no_cloud.AddCloud({{Vec3f(1e6f, -1e6f, 0.0f)}});
  EXPECT_EQ(no_cloud.coverage_raw(), 0.0);
}

TEST(PointGrid, NearestEqualsBruteForce) {
  core::Rng rng(3);
  const std::vector<Vec3f> points = RandomPoints(2000, 1.0, &rng);
  const PointGrid grid(points, 0.086);
  for (const float limit : {0.03f, 0.2f, 2.5f}) {
    for (const Vec3f& q : RandomPoints(200, 1.6, &rng)) {
      int64_t expected = -1;
      float best = limit * limit, distance = 0.0f;
      for (size_t i = 0; i < points.size(); ++i) {
        if ((points[i] - q).squaredNorm() < best) {
          best = (points[i] - q).squaredNorm();
          expected = static_cast<int64_t>(i);
        }
      }
      EXPECT_EQ(grid.Nearest(q, limit, &distance), expected);
    }
  }
}

TEST(PointGrid, ThinningKeepsOnePointACell) {
  core::Rng rng(5);
  const std::vector<Vec3f> points = RandomPoints(5000, 0.3, &rng);
  const std::vector<uint32_t> kept = ThinIndices(points, 0.1);
  EXPECT_LE(kept.size(), 7u * 7u * 7u);
  EXPECT_GE(kept.size(), 6u * 6u * 6u);
  EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
}

TEST(AlignToTruth, RecoversAKnownMotion) {
  const scenes::GroundTruth truth = SampledBox({2.0, 1.0, 0.7}, 0.01);
  const PointGrid grid(truth.points, 0.086);
  const Pose T_truth_cloud =
      core::MakePose(core::RotationFromYawPitchRoll(0.015, -0.008, 0.01), Vec3(0.03, -0.02, 0.04));
  core::Rng rng(1);
  std::vector<Vec3f> cloud;
  for (size_t i = 0; i < truth.points.size(); i += 7) {
    const Vec3 noise(rng.Normal(), rng.Normal(), rng.Normal());
    cloud.push_back(
        (T_truth_cloud.inverse() * (truth.points[i].cast<double>() + 0.01 * noise)).cast<float>());
  }
  const AlignResult result = AlignToTruth(cloud, grid, truth.points, truth.normals, Pose::Identity(), {});
  const Pose error = result.T_truth_cloud * T_truth_cloud.inverse();
  EXPECT_LT(error.translation().norm(), 0.002);
  EXPECT_LT(Eigen::AngleAxisd(error.linear()).angle(), 0.001);
  EXPECT_GT(result.pairs, 5000);
}

TEST(AlignToTruth, DirectionsThatAPlaneLeavesFreeStayPut) {
  scenes::GroundTruth wall;
  for (double x = -2.0; x <= 2.0; x += 0.01) {
    for (double z = 0.0; z <= 2.0; z += 0.01) {
      wall.points.push_back(Vec3(x, 0.0, z).cast<float>());
      wall.normals.push_back(Vec3f::UnitY());
    }
  }
  const PointGrid grid(wall.points, 0.086);
  core::Rng rng(2);
  std::vector<Vec3f> cloud;
  for (int i = 0; i < 20000; ++i) {
    cloud.push_back(
        Vec3(rng.Uniform(-1.8, 1.8), 0.04 + 0.01 * rng.Normal(), rng.Uniform(0.2, 1.8)).cast<float>());
  }
  const Pose T = AlignToTruth(cloud, grid, wall.points, wall.normals, Pose::Identity(), {}).T_truth_cloud;
  EXPECT_NEAR(T.translation().y(), -0.04, 0.002);
  EXPECT_NEAR(T.translation().x(), 0.0, 0.002);
  EXPECT_NEAR(T.translation().z(), 0.0, 0.002);
}

TEST(CoverageMeter, AlignmentGivesBackWhatDriftTook) {
  const scenes::GroundTruth truth = SampledBox({1.5, 0.8, 0.6}, 0.01);
  CoverageMeter meter(truth, {});
  mapping::ReturnCloud first, second;
  for (size_t i = 0; i < truth.points.size(); ++i) {
    // The first half of the truth is seen by the first scan, all by the second; both shifted by 6 cm.
    const Vec3f p = truth.points[i] + Vec3f(0.035f, 0.035f, 0.035f);
    if (truth.points[i].x() < 0.0f) first.Add(p, p + truth.normals[i]);
    second.Add(p, p + truth.normals[i]);
  }
  meter.AddCloud(first);
  const double after_one = meter.coverage();
  EXPECT_GT(after_one, 0.4);
  meter.AddCloud(second);
  EXPECT_GT(meter.coverage(), 0.999);
  EXPECT_GT(meter.coverage_outer(), 0.999);
  EXPECT_LT(meter.coverage_raw(), meter.coverage());
  EXPECT_NEAR((meter.T_truth_cloud().translation() + Vec3(0.035, 0.035, 0.035)).norm(), 0.0, 0.003);
  const std::vector<PartCoverage> parts = CoverageByPart(truth, meter.covered());
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_GT(parts[2].share(), 0.99);
}

TEST(CoverageMeter, ACloudMovesWithItsKeyframe) {
  const scenes::GroundTruth truth = SampledBox({1.5, 0.8, 0.6}, 0.01);
  // What keyframe 1 sees is 20 cm off, until a loop closes. Keyframe 0 holds still.
  const core::Pose right = core::PoseFromXyzYaw({3.0, 1.0, 0.0}, 0.5),
                   wrong = core::PoseFromXyzYaw({3.0, 1.2, 0.0}, 0.52);
  const Eigen::Isometry3f move = (wrong * right.inverse()).cast<float>();
  mapping::ReturnCloud first, second;
  for (size_t i = 0; i < truth.points.size(); ++i) {
    const Vec3f &p = truth.points[i], o = p + truth.normals[i];
    p.x() < 0.0f ? first.Add(p, o) : second.Add(move * p, move * o);
  }
  const mapping::FixedPoses before({core::Pose::Identity(), wrong}), after({core::Pose::Identity(), right});
  CoverageMeter meter(truth, {});
  meter.Take(first, 0, before);
  meter.Take(second, 1, before);
  meter.Align();
  EXPECT_LT(meter.coverage_outer(), 0.9);
  meter.Correct(after);
  meter.Align();
  EXPECT_GT(meter.coverage_raw(), 0.999);
  EXPECT_GT(meter.coverage_outer(), 0.999);
  ASSERT_EQ(meter.kept().points.size(), truth.points.size());
  const double all = meter.coverage();
  meter.Correct(after);
  EXPECT_EQ(meter.coverage(), all) << "nothing moved";
}

TEST(CoverageMeter, CloudErrorIsTheDistanceToTheSurfaceAndLeavesTheGroundOut) {
  const scenes::GroundTruth truth = SampledBox({1.0, 1.0, 0.5}, 0.01);
  CoverageMeter meter(truth, {});
  mapping::ReturnCloud cloud;
  core::Rng rng(4);
  std::vector<double> expected;
  for (int i = 0; i < 40000; ++i) {
    const size_t k = static_cast<size_t>(rng.UniformInt(static_cast<int>(truth.points.size())));
    const double offset = 0.01 * rng.Normal();
    if (truth.points[k].cwiseAbs().maxCoeff() > 0.95f && truth.part[k] == 2) continue;
    cloud.Add(truth.points[k] + static_cast<float>(offset) * truth.normals[k], Vec3f(0, 0, 5));
  }
  std::vector<Vec3f> ground;
  for (double x = -1.5; x <= 1.5; x += 0.02) {
    for (double y = -1.5; y <= 1.5; y += 0.02) {
      if (std::max(std::abs(x), std::abs(y)) > 1.02) ground.push_back(Vec3(x, y, -0.5).cast<float>());
    }
  }
  for (const Vec3f& p : ground) cloud.Add(p, Vec3f(0, 0, 5));
  meter.AddCloud(cloud);
  meter.SetSurroundings(ground);
  const CloudError error = meter.MeasureCloudError(Box3{Vec3(-2, -2, -1), Vec3(2, 2, 1)});
  EXPECT_NEAR(error.mean_m, 0.01 * std::sqrt(2.0 / core::kPi), 0.0008);  // half-normal mean
  EXPECT_NEAR(error.p95_m, 0.0196, 0.0015);
}

TEST(CoverageMeter, KeepsReturnsWithinHalfAMetreOfTheTruthsBoxAndErrorsEndAtHalfAMetre) {
  const scenes::GroundTruth truth = SampledBox({1.0, 1.0, 1.0}, 0.05);
  CoverageMeter meter(truth, {});
  mapping::ReturnCloud cloud;
  for (const float x : {1.3f, 1.49f, 1.51f}) cloud.Add(Vec3f(x, 0, 0), Vec3f(5, 0, 0));
  cloud.Add(Vec3f(1.45f, 1.45f, 0), Vec3f(5, 5, 0));  // 0.64 m from the edge
  meter.Take(cloud);
  EXPECT_EQ(meter.kept().points.size(), 3u);
  const CloudError error = meter.MeasureCloudError(Box3{Vec3(-3, -3, -3), Vec3(3, 3, 3)});
  ASSERT_EQ(error.points, 3u);
  EXPECT_NEAR(error.mean_m, (0.3 + 0.49 + 0.5) / 3.0, 1e-3);
}

TEST(CoverageScorer, MillionsOfPointsAreScoredAndAlignedInSeconds) {
  const scenes::GroundTruth truth = SampledBox({5.0, 4.0, 3.0}, 0.0115);
  const clock_t begin = clock();
  CoverageMeter meter(truth, {});
  const double build_s = static_cast<double>(clock() - begin) / CLOCKS_PER_SEC;
  core::Rng rng(8);
  double worst_s = 0.0;
  for (int scan = 0; scan < 4; ++scan) {
    mapping::ReturnCloud cloud;
    for (int i = 0; i < 300000; ++i) {
      const size_t k = static_cast<size_t>(rng.UniformInt(static_cast<int>(truth.points.size())));
      const float offset = static_cast<float>(0.01 * rng.Normal());
      cloud.Add(truth.points[k] + offset * truth.normals[k], truth.points[k] + 3.0f * truth.normals[k]);
    }
    const clock_t start = clock();
    meter.AddCloud(cloud);
    worst_s = std::max(worst_s, static_cast<double>(clock() - start) / CLOCKS_PER_SEC);
  }
  RecordProperty("truth_points", static_cast<int>(truth.points.size()));
  RecordProperty("build_ms", static_cast<int>(1e3 * build_s));
  RecordProperty("worst_cloud_ms", static_cast<int>(1e3 * worst_s));
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
  EXPECT_LT(worst_s, 16.0);
#else
  EXPECT_LT(worst_s, 4.0);  // 0.5 s built for release
#endif
}

TEST(ClipTriangle, AreaIsThatOfTheIntersection) {
  const Box3 box{Vec3(0, 0, -1), Vec3(1, 1, 1)};
  // The triangle covers the unit square up to x + y = 1.2.
  const auto polygon = ClipTriangle({Vec3(-1, -1, 0), Vec3(2.2, -1, 0), Vec3(-1, 2.2, 0)}, box);
  double area = 0.0;
  for (size_t i = 2; i < polygon.size(); ++i) {
    area += 0.5 * (polygon[i - 1] - polygon[0]).cross(polygon[i] - polygon[0]).norm();
  }
  EXPECT_NEAR(area, 1.0 - 0.5 * 0.8 * 0.8, 1e-12);
  EXPECT_TRUE(ClipTriangle({Vec3(2, 2, 0), Vec3(3, 2, 0), Vec3(2, 3, 0)}, box).empty());
}

}  // namespace
}  // namespace atlas::experiments
