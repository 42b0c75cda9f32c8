#include "experiments/judge/surface_score.h"

#include <gtest/gtest.h>

#include "core/errors.h"
#include "core/rng.h"

namespace atlas::experiments {
namespace {

using core::Vec3;
using core::Vec3f;

std::vector<Vec3f> RandomPoints(uint64_t seed, size_t count, double side) {
  core::Rng rng(seed);
  std::vector<Vec3f> points(count);
  for (Vec3f& p : points) {
    p = Vec3(rng.Uniform(0.0, side), rng.Uniform(0.0, side), rng.Uniform(0.0, side)).cast<float>();
  }
  return points;
}

/// Walls of a room corner, 1.2 m, a point every `spacing`.
std::vector<Vec3f> Corner(double spacing) {
  std::vector<Vec3f> points;
  for (double u = 0.0; u < 1.2; u += spacing) {
    for (double v = 0.0; v < 1.2; v += spacing) {
      for (const Vec3& p : {Vec3(u, v, 0.0), Vec3(u, 0.0, v), Vec3(0.0, u, v)})
        points.push_back(p.cast<float>());
    }
  }
  return points;
}

core::TriMesh Square(double side, int cells) {
  core::TriMesh mesh;
  for (int j = 0; j <= cells; ++j) {
    for (int i = 0; i <= cells; ++i) mesh.vertices.push_back((side / cells * Vec3(i, j, 0)).cast<float>());
  }
  const auto at = [&](int i, int j) { return static_cast<uint32_t>(j * (cells + 1) + i); };
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

TEST(SurfaceScore, EqualsAllPairsOfDistances) {
  const auto truth = RandomPoints(1, 400, 2.0), surface = RandomPoints(2, 300, 3.0);
  SurfaceScoreOptions options;
  options.radii_m = {0.1, 0.3, 0.7};
  const auto nearest = [&](const Vec3f& p, const std::vector<Vec3f>& others) {
    double best = 1e9;
    for (const Vec3f& q : others) best = std::min(best, static_cast<double>((p - q).norm()));
    return best;
  };
  double accuracy = 0.0, completeness = 0.0, outliers = 0.0;
  std::vector<double> covered(3, 0.0), distances;
  for (const Vec3f& p : surface) {
    distances.push_back(std::min(nearest(p, truth), 0.5));
    accuracy += distances.back();
    outliers += distances.back() >= 0.5;
  }
  for (const Vec3f& p : truth) {
    const double d = nearest(p, surface);
    completeness += std::min(d, 0.5);
    for (size_t k = 0; k < 3; ++k) covered[k] += d <= options.radii_m[k];
  }
  std::sort(distances.begin(), distances.end());

  const SurfaceScore score = SurfaceScorer(truth, options).Score(surface, core::Pose::Identity());
  EXPECT_NEAR(score.accuracy_mean_m, accuracy / 300.0, 1e-5);
  EXPECT_NEAR(score.accuracy_median_m, distances[149], 1e-5);
  EXPECT_NEAR(score.accuracy_p95_m, distances[static_cast<size_t>(0.95 * 299)], 1e-5);
  EXPECT_NEAR(score.outlier_share, outliers / 300.0, 1e-9);
  EXPECT_NEAR(score.completeness_mean_m, completeness / 400.0, 1e-5);
  for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(score.coverage[k], covered[k] / 400.0, 1e-9);
}

TEST(SurfaceScore, AlignmentTakesBackASmallMotion) {
  const auto truth = Corner(0.01);
  const core::Pose T_truth_surface =
      core::MakePose(core::RotationFromYawPitchRoll(0.01, -0.008, 0.012), Vec3(0.03, -0.02, 0.025));
  std::vector<Vec3f> surface = Corner(0.013);
  for (Vec3f& p : surface) p = (T_truth_surface.inverse() * p.cast<double>()).cast<float>();
  const SurfaceScorer scorer(truth, {});
  const AlignResult fit = scorer.Align(surface);
  EXPECT_LT((fit.T_truth_cloud.translation() - T_truth_surface.translation()).norm(), 0.002);
  const SurfaceScore raw = scorer.Score(surface, core::Pose::Identity());
  const SurfaceScore aligned = scorer.Score(surface, fit.T_truth_cloud);
  EXPECT_GT(raw.accuracy_mean_m, 0.02);
  EXPECT_LT(aligned.accuracy_mean_m, 0.007) << "half the spacing of the truth";
  EXPECT_GT(aligned.coverage[0], 0.999);
}

TEST(SurfaceScore, ThreadsChangeNothing) {
  const auto truth = RandomPoints(3, 5000, 2.0), surface = RandomPoints(4, 5000, 2.0);
  SurfaceScoreOptions options;
  const SurfaceScore one = SurfaceScorer(truth, options).Score(surface, core::Pose::Identity());
  options.threads = 3;
  const SurfaceScore three = SurfaceScorer(truth, options).Score(surface, core::Pose::Identity());
  EXPECT_EQ(one.accuracy_mean_m, three.accuracy_mean_m);
  EXPECT_EQ(one.completeness_mean_m, three.completeness_mean_m);
  EXPECT_EQ(one.coverage, three.coverage);
}

TEST(SurfaceScore, FarStrayPointsAreOutliersNotMemory) {
  const auto truth = Corner(0.02);
  auto surface = truth;
  surface.push_back({90000.0f, 90000.0f, -90000.0f});
  surface.push_back({-90000.0f, 90000.0f, 90000.0f});
  const SurfaceScore score = SurfaceScorer(truth, {}).Score(surface, core::Pose::Identity());
  EXPECT_NEAR(score.outlier_share, 2.0 / static_cast<double>(surface.size()), 1e-9);
  EXPECT_EQ(score.coverage[0], 1.0);
}

TEST(SurfaceScore, AnEmptyTruthIsRefused) {
  EXPECT_THROW(SurfaceScorer({}, {}), core::InputError);
}

TEST(SurfaceScore, SamplesOfAMeshLieOnItEvenly) {
  for (const int cells : {1, 40}) {  // triangles larger and smaller than the spacing
    const double spacing = 0.05;
    const std::vector<Vec3f> samples = SampleMesh(Square(2.0, cells), spacing);
    EXPECT_NEAR(static_cast<double>(samples.size()), 4.0 / (spacing * spacing), 2.0);
    double widest = 0.0;
    for (double x = 0.1; x < 1.9; x += 0.03) {
      for (double y = 0.1; y < 1.9; y += 0.03) {
        double best = 1e9;
        for (const Vec3f& p : samples) {
          best = std::min(best, (p.cast<double>() - Vec3(x, y, 0.0)).norm());
        }
        widest = std::max(widest, best);
      }
    }
    EXPECT_LT(widest, 2.0 * spacing) << cells;
    for (const Vec3f& p : samples) EXPECT_EQ(p.z(), 0.0f);
  }
}

TEST(SurfaceScore, NormalsOfASphereAreRadial) {
  core::Rng rng(5);
  std::vector<Vec3f> points(4000);
  for (Vec3f& p : points) p = Vec3(rng.Normal(), rng.Normal(), rng.Normal()).normalized().cast<float>();
  const std::vector<Vec3f> normals = EstimateNormals(points, 12);
  for (size_t i = 0; i < points.size(); ++i) EXPECT_GT(std::abs(normals[i].dot(points[i])), 0.97f);
}

TEST(SurfaceScore, PointsOnALineHaveNoNormal) {
  std::vector<Vec3f> points;
  for (int i = 0; i < 20; ++i) points.push_back({0.1f * static_cast<float>(i), 0.0f, 0.0f});
  for (const Vec3f& n : EstimateNormals(points, 6)) EXPECT_EQ(n, Vec3f::Zero());
}

}  // namespace
}  // namespace atlas::experiments
