#include "experiments/judge/surface_score.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "core/errors.h"
#include "core/parallel_for.h"
#include "experiments/results/statistics.h"

namespace atlas::experiments {
namespace {

using core::Pose;
using core::Vec3f;

constexpr size_t kAlignTruthPoints = 500000;
constexpr double kAlignSpacingM = 0.03;
constexpr int kNormalNeighbours = 12;

constexpr double kMaxGridBlocks = 1 << 26;

core::Box3 BoundsOf(std::span<const Vec3f> points) {
  core::Box3 box;
  for (const Vec3f& p : points) box.Extend(p.cast<double>());
  return box;
}

/// Cells a few points wide: few to look at near a surface, few rings up to the limit. Wider ones where the
/// points spread so far that the grid's table would not fit.
double CellFor(const SurfaceScoreOptions& options, std::span<const Vec3f> points) {
  const double radius = *std::min_element(options.radii_m.begin(), options.radii_m.end());
  if (points.empty()) return options.limit_m;
  const core::Vec3 size = BoundsOf(points).Size().array() + options.limit_m;
  const double least = std::cbrt(size.prod() / kMaxGridBlocks) / 8.0;
  return std::max(least, std::clamp(2.0 * radius, 0.1 * options.limit_m, options.limit_m));
}

std::vector<Vec3f> Checked(std::vector<Vec3f> truth) {
  if (truth.empty()) throw core::InputError("the truth cloud has no points");
  return truth;
}

/// Distance of each point to the nearest of the grid, `limit_m` where there is none so near.
std::vector<float> NearestDistances(std::span<const Vec3f> points, const PointGrid& grid, double limit_m,
                                    int threads) {
  const auto limit = static_cast<float>(limit_m);
  std::vector<float> distances(points.size(), limit);
  core::ParallelFor(threads, points.size(), [&](size_t begin, size_t end, size_t) {
    for (size_t i = begin; i < end; ++i) {
      float distance = limit;
      if (grid.Nearest(points[i], limit, &distance) >= 0) distances[i] = distance;
    }
  });
  return distances;
}

double MeanOf(const std::vector<float>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) /
         static_cast<double>(std::max<size_t>(values.size(), 1));
}

/// The q-th of the values in order; reorders them.
double QuantileOf(std::vector<float>* values, double share) {
  if (values->empty()) return 0.0;
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values->size() - 1));
  std::nth_element(values->begin(), values->begin() + at, values->end());
  return (*values)[static_cast<size_t>(at)];
}

std::vector<Vec3f> Moved(std::span<const Vec3f> points, const Pose& T) {
  const Eigen::Isometry3f moved = T.cast<float>();
  std::vector<Vec3f> out(points.begin(), points.end());
  if (T.matrix() == Pose::Identity().matrix()) return out;
  for (Vec3f& p : out) p = moved * p;
  return out;
}

}  // namespace

SurfaceScorer::SurfaceScorer(std::vector<Vec3f> truth, const SurfaceScoreOptions& options)
    : options_(options), truth_(Checked(std::move(truth))), grid_(truth_, CellFor(options, truth_)) {
  assert(!options.radii_m.empty() && options.limit_m > 0.0);
}

SurfaceScore SurfaceScorer::Score(std::span<const Vec3f> surface, const Pose& T_truth_surface) const {
  const std::vector<Vec3f> samples = Moved(surface, T_truth_surface);
  SurfaceScore score;
  score.coverage.assign(options_.radii_m.size(), 0.0);
  score.completeness_mean_m = options_.limit_m;
  if (samples.empty()) return score;

  std::vector<float> accuracy = NearestDistances(samples, grid_, options_.limit_m, options_.threads);
  const auto limit = static_cast<float>(options_.limit_m);
  score.accuracy_mean_m = MeanOf(accuracy);
  score.outlier_share = static_cast<double>(std::count(accuracy.begin(), accuracy.end(), limit)) /
                        static_cast<double>(accuracy.size());
  score.accuracy_median_m = QuantileOf(&accuracy, 0.5);
  score.accuracy_p95_m = QuantileOf(&accuracy, 0.95);

  const double reach_m =
      std::max(options_.limit_m, *std::max_element(options_.radii_m.begin(), options_.radii_m.end()));
  std::vector<Vec3f> near;  // strays would widen the grid
  const core::Box3 box = BoundsOf(truth_).Inflated(reach_m);
  std::copy_if(samples.begin(), samples.end(), std::back_inserter(near),
               [&](const Vec3f& p) { return box.Contains(p.cast<double>()); });
  const PointGrid surface_grid(near, CellFor(options_, near));
  std::vector<float> completeness = NearestDistances(truth_, surface_grid, reach_m, options_.threads);
  for (size_t k = 0; k < options_.radii_m.size(); ++k) {
    const auto radius = static_cast<float>(options_.radii_m[k]);
    const auto covered =
        std::count_if(completeness.begin(), completeness.end(), [&](float d) { return d <= radius; });
    score.coverage[k] = static_cast<double>(covered) / static_cast<double>(truth_.size());
  }
  for (float& d : completeness) d = std::min(d, limit);
  score.completeness_mean_m = MeanOf(completeness);
  return score;
}

AlignResult SurfaceScorer::Align(std::span<const Vec3f> surface) const {
  std::vector<Vec3f> thin;
  for (double spacing = kAlignSpacingM;; spacing *= 1.5) {
    const std::vector<uint32_t> kept = ThinIndices(truth_, spacing);
    if (kept.size() > kAlignTruthPoints) continue;
    for (const uint32_t i : kept) thin.push_back(truth_[i]);
    break;
  }
  const PointGrid grid(thin, CellFor(options_, thin));
  return AlignToTruth(surface, grid, thin, EstimateNormals(thin, kNormalNeighbours), Pose::Identity(), {});
}

std::vector<Vec3f> SampleMesh(const core::TriMesh& mesh, double spacing_m) {
  // Points of the plane's R2 sequence, folded into the triangle: even within each, whatever its size.
  constexpr double kStepU = 0.7548776662466927, kStepV = 0.5698402909980532;
  std::vector<Vec3f> samples;
  double owed = 0.0, u = 0.5, v = 0.5;
  for (const auto& t : mesh.triangles) {
    const Vec3f &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    owed += 0.5 * static_cast<double>((b - a).cross(c - a).norm()) / (spacing_m * spacing_m);
    for (; owed >= 1.0; owed -= 1.0) {
      u = std::fmod(u + kStepU, 1.0);
      v = std::fmod(v + kStepV, 1.0);
      const bool fold = u + v > 1.0;
      const auto fu = static_cast<float>(fold ? 1.0 - u : u), fv = static_cast<float>(fold ? 1.0 - v : v);
      samples.push_back(a + fu * (b - a) + fv * (c - a));
    }
  }
  return samples;
}

}  // namespace atlas::experiments
