#include "experiments/record/truth_seen.h"

#include <algorithm>

#include "core/parallel_for.h"

namespace atlas::experiments {
namespace {

using core::Vec3f;

constexpr size_t kTries = 8;
constexpr float kTolerance_m = 0.02f;
/// A surface seen at a flatter angle than this (sine) has no returns to speak of.
constexpr float kLeastIncidence = 0.02f;

struct FieldOfView {
  float min_sine, max_sine;
  explicit FieldOfView(const core::LidarModel& lidar) {
    const auto [low, high] = std::minmax_element(lidar.elevation_rad.begin(), lidar.elevation_rad.end());
    min_sine = static_cast<float>(std::sin(*low));
    max_sine = static_cast<float>(std::sin(*high));
  }
};

struct View {
  Vec3f p_map;
  Vec3f up;  ///< the spin axis
};

/// The tries of a batch of points, and which point each belongs to.
struct Tries {
  std::vector<core::Ray> rays;
  std::vector<float> distance_m;
  std::vector<size_t> point;
};

void AddTries(const Vec3f& p, const Vec3f& normal, size_t index, const std::vector<View>& views,
              const FieldOfView& fov, const core::LidarModel& lidar, Tries* tries) {
  std::vector<std::pair<float, const View*>> good;
  for (const View& view : views) {
    const Vec3f to_point = p - view.p_map;
    const float distance = to_point.norm(), up = view.up.dot(to_point);
    if (distance < lidar.min_range_m || distance > lidar.max_range_m) continue;
    if (up < fov.min_sine * distance || up > fov.max_sine * distance) continue;
    if (-normal.dot(to_point) < kLeastIncidence * distance) continue;
    good.emplace_back(distance, &view);
  }
  const size_t count = std::min(kTries, good.size());
  std::partial_sort(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(count), good.end());
  for (size_t k = 0; k < count; ++k) {
    const auto& [distance, view] = good[k];
    tries->rays.push_back({view->p_map, (p - view->p_map) / distance});
    tries->distance_m.push_back(distance);
    tries->point.push_back(index);
  }
}

}  // namespace

std::vector<uint8_t> SeenPoints(std::span<const Vec3f> points, std::span<const Vec3f> normals,
                                const std::vector<core::StampedPose>& T_map_lidar,
                                const core::LidarModel& lidar, const sim::Raycaster& raycaster, int threads) {
  std::vector<View> views;
  for (const core::StampedPose& pose : T_map_lidar) {
    views.push_back({pose.T.translation().cast<float>(), pose.T.linear().col(2).cast<float>()});
  }
  const FieldOfView fov(lidar);
  std::vector<uint8_t> seen(points.size(), 0);
  core::ParallelFor(threads, points.size(), [&](size_t begin, size_t end, size_t) {
    constexpr size_t kBatch = 4096;
    Tries tries;
    std::vector<sim::RayHit> hits;
    for (size_t first = begin; first < end; first += kBatch) {
      tries = {};
      for (size_t i = first; i < std::min(end, first + kBatch); ++i) {
        AddTries(points[i], normals[i], i, views, fov, lidar, &tries);
      }
      hits.assign(tries.rays.size(), {});
      raycaster.CastStatic(tries.rays, static_cast<float>(lidar.max_range_m) + 1.0f, 1, hits);
      for (size_t k = 0; k < hits.size(); ++k) {
        const bool met = hits[k].range_m >= tries.distance_m[k] - kTolerance_m;
        if (met || hits[k].range_m < 0.0f) seen[tries.point[k]] = 1;
      }
    }
  });
  return seen;
}

}  // namespace atlas::experiments
