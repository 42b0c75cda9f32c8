#include "experiments/judge/attainable.h"

#include <fmt/format.h>

#include <cmath>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "core/errors.h"
#include "core/parallel_for.h"
#include "core/rng.h"
#include "experiments/judge/attainable_cache.h"
#include "experiments/judge/scene_surface.h"
#include "experiments/judge/sweep_aim.h"
#include "sim/sensors/raycaster.h"

namespace atlas::experiments {
namespace {

using core::Vec3;
using core::Vec3f;

// A ray that ends this close to the sample it was aimed at has met it.
constexpr float kMetWithinM = 0.01f;
// Samples share a bucket of this size; late positions aim at one of each bucket in turn.
constexpr double kBucketM = 0.06;
constexpr int kCoarsestStride = 16;
// Views that add less of what is wanted are not worth their ray.
constexpr float kLeastShare = 0.01f;

/// Surface samples that rays are aimed at: thinned truth, and what else lies within the scoring radius of
/// truth (ground at its foot), whose hits count too.
struct Targets {
  std::vector<Vec3f> p;
  std::vector<Vec3f> normal;           ///< zero: unknown
  std::vector<uint8_t> two_sided;      ///< 1: seen from either side
  std::vector<uint32_t> bucket_begin;  ///< targets of one bucket are consecutive; one more at the end
};

/// The side of a cube that a normal points through, from 0 to 5.
int CubeSide(const Vec3f& n) {
  int axis = 0;
  n.cwiseAbs().maxCoeff(&axis);
  return 2 * axis + (n[axis] > 0.0f ? 1 : 0);
}

/// Thinned truth: of each cell one point for each side of a cube that its surfaces face, so that both faces
/// of an edge or a thin plate have theirs.
std::vector<uint32_t> ThinBySide(const scenes::GroundTruth& truth, double spacing_m) {
  std::vector<uint32_t> side_index[6];
  std::vector<Vec3f> side_points[6];
  for (uint32_t i = 0; i < truth.points.size(); ++i) {
    const auto side = static_cast<size_t>(CubeSide(truth.normals[i]));
    side_index[side].push_back(i);
    side_points[side].push_back(truth.points[i]);
  }
  std::vector<uint32_t> chosen;
  for (size_t side = 0; side < 6; ++side) {
    for (const uint32_t k : ThinIndices(side_points[side], spacing_m)) chosen.push_back(side_index[side][k]);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

Targets ChooseTargets(const scenes::SceneSpec& scene, const scenes::GroundTruth& truth, const PointGrid& grid,
                      const AttainableOptions& options) {
  Targets chosen;
  for (const uint32_t i : ThinBySide(truth, options.target_spacing_m)) {
    chosen.p.push_back(truth.points[i]);
    chosen.normal.push_back(truth.normals[i]);
    chosen.two_sided.push_back(truth.two_sided.empty() ? 0 : truth.two_sided[i]);
  }
  core::Box3 box;
  for (const Vec3f& p : truth.points) box.Extend(p.cast<double>());
  const std::vector<Vec3f> others =
      SampleBackground(scene, box.Inflated(options.radius_m), options.target_spacing_m);
  for (const uint32_t i : ThinIndices(others, options.target_spacing_m)) {
    float distance;
    if (grid.Nearest(others[i], static_cast<float>(options.radius_m), &distance) < 0) continue;
    chosen.p.push_back(others[i]);
    chosen.normal.push_back(Vec3f::Zero());
    chosen.two_sided.push_back(1);
  }
  // Bring the targets of one bucket together.
  const PointGrid buckets(chosen.p, kBucketM);
  Targets sorted;
  for (size_t cell = 0; cell < buckets.cell_count(); ++cell) {
    const uint32_t begin = buckets.CellBegin(static_cast<int32_t>(cell)),
                   end = buckets.CellEnd(static_cast<int32_t>(cell));
    if (begin == end) continue;
    sorted.bucket_begin.push_back(begin);
    for (uint32_t k = begin; k < end; ++k) {
      sorted.p.push_back(buckets.entries()[k].p);
      sorted.normal.push_back(chosen.normal[buckets.entries()[k].index]);
      sorted.two_sided.push_back(chosen.two_sided[buckets.entries()[k].index]);
    }
  }
  sorted.bucket_begin.push_back(static_cast<uint32_t>(sorted.p.size()));
  return sorted;
}

/// A lattice position and how coarse a sub-lattice it belongs to.
struct Position {
  Vec3 ground;
  int stride;
};

/// Coarse sub-lattices first, so that most samples are closed early and later positions have little left to
/// do.
std::vector<Position> OrderedPositions(const ReachableSet& set, const Vec3& spawn, double spacing_m) {
  std::vector<Position> positions;
  for (const Vec3& ground : LatticePositions(set, spawn, spacing_m)) {
    const int i = static_cast<int>(std::lround((ground.x() - spawn.x()) / spacing_m)),
              j = static_cast<int>(std::lround((ground.y() - spawn.y()) / spacing_m));
    int stride = kCoarsestStride;
    while (i % stride != 0 || j % stride != 0) stride /= 2;
    positions.push_back({ground, stride});
  }
  std::stable_sort(positions.begin(), positions.end(),
                   [](const Position& a, const Position& b) { return a.stride > b.stride; });
  return positions;
}

class Search {
 public:
  Search(const Targets& targets, const SweepAim& aim, double rays_per_steradian, double max_range_m,
         double min_range_m, const AttainableOptions& options, const CastRays& cast)
      : targets_(targets),
        aim_(aim),
        min_range_m_(static_cast<float>(min_range_m)),
        max_range_m_(static_cast<float>(max_range_m)),
        threads_(options.threads),
        cast_(cast),
        min_rays_(static_cast<float>(options.min_rays)),
        met_from_(targets.p.size(), 0),
        expected_(targets.p.size(), 0.0f) {
    // Expected rays within the radius of a sample seen at incidence i from d: density * pi r^2 cos(i) / d^2.
    const double disc = core::kPi * options.radius_m * options.radius_m;
    rays_times_sq_ = static_cast<float>(rays_per_steradian * disc);
    for (uint32_t b = 0; b + 1 < targets.bucket_begin.size(); ++b) open_.push_back(b);
  }

  /// Aims at open samples from one position; the hits go to `scorer`.
  void From(const Position& position, size_t number, CoverageScorer* scorer) {
    position_ = static_cast<uint32_t>(number) + 1;
    yielding_.clear();
    GatherAims(position, number);
    CastAims(number);
    Score(scorer);
    if (!sampled_ || yielding_.empty()) return;
    // A bucket that yields is worth a full look from here.
    aims_.clear();
    for (const uint32_t b : std::exchange(yielding_, {})) {
      for (uint32_t k = targets_.bucket_begin[b]; k < targets_.bucket_begin[b + 1]; ++k)
        TryAim(position, k, 0, b, &aims_);
    }
    CastAims(number);
    Score(scorer);
  }

  size_t rays() const { return rays_; }

 private:
  struct Aim {
    SweepAim::Shot shot;
    uint32_t target, bucket;
    float expected;  ///< rays within the radius of the target, from this position
  };

  bool Open(uint32_t k) const { return expected_[k] < min_rays_; }

  /// Queues a ray at target `k` unless it is closed, turns its back, or lies too far or too aslant.
  void TryAim(const Position& position, uint32_t k, int variant, uint32_t bucket,
              std::vector<Aim>* aims) const {
    if (!Open(k) || met_from_[k] == position_) return;
    const Vec3f sensor = (position.ground + Vec3(0.0, 0.0, aim_.sensor_height_m())).cast<float>();
    const Vec3f back = sensor - targets_.p[k];
    const float distance_sq = back.squaredNorm();
    const float reach = max_range_m_ + static_cast<float>(aim_.sensor_reach_m());
    if (distance_sq > reach * reach) return;
    // Cheap first look from the level sensor, widened by how far a roll may carry it.
    const Vec3f& n = targets_.normal[k];
    if (targets_.two_sided[k] == 0 && n.dot(back) < -static_cast<float>(aim_.sensor_reach_m())) return;
    Aim aim{.shot = {}, .target = k, .bucket = bucket, .expected = 0.0f};
    if (!aim_.At(position.ground, targets_.p[k], variant, &aim.shot)) return;
    const float d = aim.shot.distance_m;
    if (d < min_range_m_ || d > max_range_m_) return;
    float cosine = -n.dot(aim.shot.direction);
    if (targets_.two_sided[k] != 0) cosine = n.isZero() ? 1.0f : std::abs(cosine);
    aim.expected = rays_times_sq_ * cosine / (d * d);
    if (aim.expected < kLeastShare * min_rays_) return;
    aims->push_back(aim);
  }

  void GatherAims(const Position& position, size_t number) {
    // Buckets whose samples are all closed leave the list.
    std::erase_if(open_, [&](uint32_t b) {
      for (uint32_t k = targets_.bucket_begin[b]; k < targets_.bucket_begin[b + 1]; ++k) {
        if (Open(k)) return false;
      }
      return true;
    });
    sampled_ = position.stride < 2;
    const int variant = sampled_ ? static_cast<int>(core::HashCounter(17, number) % 3) : 0;
    std::vector<std::vector<Aim>> found(static_cast<size_t>(std::max(threads_, 1)));
    core::ParallelFor(threads_, open_.size(), [&](size_t begin, size_t end, size_t worker) {
      for (size_t i = begin; i < end; ++i) {
        const uint32_t b = open_[i], first = targets_.bucket_begin[b], last = targets_.bucket_begin[b + 1];
        if (!sampled_) {
          for (uint32_t k = first; k < last; ++k) TryAim(position, k, variant, b, &found[worker]);
          continue;
        }
        // One open sample of the bucket, another one each time.
        const uint32_t count = last - first,
                       start = static_cast<uint32_t>(core::HashCounter(b, number) % count);
        for (uint32_t step = 0; step < count; ++step) {
          const uint32_t k = first + (start + step) % count;
          if (!Open(k)) continue;
          TryAim(position, k, variant, b, &found[worker]);
          break;
        }
      }
    });
    aims_.clear();
    for (const std::vector<Aim>& part : found) aims_.insert(aims_.end(), part.begin(), part.end());
  }

  void CastAims(size_t number) {
    std::vector<core::Ray> rays(aims_.size());
    for (size_t i = 0; i < aims_.size(); ++i) rays[i] = {aims_[i].shot.origin, aims_[i].shot.direction};
    range_.resize(rays.size());
    cast_(rays, max_range_m_, core::HashCounter(29, number), range_);
    rays_ += rays.size();
  }

  /// All that met a sample count once it is closed, each from where it was seen.
  void Score(CoverageScorer* scorer) {
    mapping::ReturnCloud hits;
    for (size_t i = 0; i < aims_.size(); ++i) {
      if (range_[i] < min_range_m_) continue;
      const Aim& aim = aims_[i];
      if (std::abs(range_[i] - aim.shot.distance_m) > kMetWithinM || !Open(aim.target)) continue;
      met_from_[aim.target] = position_;
      expected_[aim.target] += aim.expected;
      const Vec3f hit = aim.shot.origin + range_[i] * aim.shot.direction;
      if (Open(aim.target)) {
        waiting_[aim.target].Add(hit, aim.shot.origin);
      } else {
        hits.Add(hit, aim.shot.origin);
        if (const auto waiting = waiting_.extract(aim.target)) {
          const mapping::ReturnCloud& earlier = waiting.mapped();
          for (size_t k = 0; k < earlier.points.size(); ++k) hits.Add(earlier.points[k], earlier.origins[k]);
        }
      }
      if (yielding_.empty() || yielding_.back() != aim.bucket) yielding_.push_back(aim.bucket);
    }
    scorer->AddReturns(hits.points, hits.origins, core::Pose::Identity());
  }

  const Targets& targets_;
  const SweepAim& aim_;
  float min_range_m_, max_range_m_;
  float rays_times_sq_ = 0.0f;  ///< expected rays, times distance squared, at normal incidence
  int threads_;
  const CastRays& cast_;
  float min_rays_;
  std::vector<uint32_t> met_from_;  // the latest position that met each target, from 1
  uint32_t position_ = 0;
  std::unordered_map<uint32_t, mapping::ReturnCloud> waiting_;  // hits on targets that are open still
  std::vector<float> expected_;  // rays within the radius of each target, of all positions so far
  std::vector<uint32_t> open_;   // buckets with open samples
  std::vector<Aim> aims_;
  std::vector<float> range_;
  std::vector<uint32_t> yielding_;  // buckets of which this position met a sample
  bool sampled_ = false;
  size_t rays_ = 0;
};

}  // namespace

ReachableSet ReachableForScanning(const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                                  const core::LidarModel& lidar, const AttainableOptions& options) {
  const double range = std::min(options.max_range_m, lidar.max_range_m);
  core::Box3 region = scene.object_box.Inflated(range);
  region.Extend(scene.T_map_spawn.translation() -
                Vec3::Ones());  // the flood starts there, wherever the object is
  region.Extend(scene.T_map_spawn.translation() + Vec3::Ones());
  region.min = region.min.cwiseMax(scene.bounds.min);
  region.max = region.max.cwiseMin(scene.bounds.max);
  region.min.z() = scene.bounds.min.z() - 0.01;
  region.max.z() = scene.bounds.max.z() + 0.01;
  return FindReachable(scene, robot, region, options.reach);
}

Attainable ComputeAttainable(const scenes::SceneSpec& scene, const scenes::GroundTruth& truth,
                             const robots::RobotSpec& robot, const core::LidarModel& lidar,
                             const AttainableOptions& options, const CastRays& cast,
                             const AttainableProgress& progress) {
  const ReachableSet reachable = ReachableForScanning(scene, robot, lidar, options);
  const std::vector<Position> positions =
      OrderedPositions(reachable, scene.T_map_spawn.translation(), options.lattice_m);

  const auto grid = std::make_shared<const PointGrid>(truth.points, 2.0 * options.radius_m);
  const Targets targets = ChooseTargets(scene, truth, *grid, options);
  const SweepAim aim(robot, lidar, options.headings, core::Radians(options.sweep_roll_deg));
  CoverageScorer scorer(grid, truth, options.radius_m);
  Search search(targets, aim, aim.RaysPerSteradian(lidar, options.headings, options.sweep_period_s),
                std::min(options.max_range_m, lidar.max_range_m), lidar.min_range_m, options, cast);
  for (size_t i = 0; i < positions.size(); ++i) {
    search.From(positions[i], i, &scorer);
    if (progress && i % 50 == 0) progress(static_cast<double>(i) / static_cast<double>(positions.size()));
  }
  return {.attainable = scorer.covered(),
          .coverage = scorer.coverage_raw(),
          .positions = positions.size(),
          .reachable_area_m2 = reachable.AreaM2(),
          .rays = search.rays()};
}

CastRays SceneRays(const scenes::SceneSpec& scene, int threads) {
  const auto raycaster = std::make_shared<sim::Raycaster>(scene);
  raycaster->CommitPoses();
  return [raycaster, threads](std::span<const core::Ray> rays, float max_range_m, uint64_t seed,
                              std::span<float> range_m) {
    std::vector<sim::RayHit> hits(rays.size());
    raycaster->Cast(rays, max_range_m, seed, threads, hits);
    for (size_t i = 0; i < rays.size(); ++i) range_m[i] = hits[i].range_m;
  };
}

Attainable LoadOrComputeAttainable(const scenes::SceneSpec& scene, const scenes::GroundTruth& truth,
                                   const robots::RobotSpec& robot, const core::LidarModel& lidar,
                                   const AttainableOptions& options,
                                   const std::filesystem::path& cache_folder,
                                   const AttainableProgress& progress) {
  const uint64_t key = AttainableKey(scene, truth, robot, lidar, options);
  const std::filesystem::path path = cache_folder / fmt::format("attainable_{:016x}.bits", key);
  if (std::optional<Attainable> kept = ReadAttainable(path, key, truth.points.size()))
    return std::move(*kept);

  Attainable set =
      ComputeAttainable(scene, truth, robot, lidar, options, SceneRays(scene, options.threads), progress);
  try {
    WriteAttainable(path, key, set);
  } catch (const core::InputError&) {
    // A cache is a convenience: a read-only installation computes each time.
  }
  return set;
}

}  // namespace atlas::experiments
