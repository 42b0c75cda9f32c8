#include "experiments/bench/map_quality.h"

#include <algorithm>
#include <array>

namespace atlas::experiments {
namespace {

using core::Vec3;
using core::Vec3f;
using mapping::CellState;

constexpr double kGrazing_rad = core::Radians(80.0);
constexpr double kLargeSpacings = 1.5;
constexpr double kContinuous = 0.25;  ///< of the range: neighbours farther off belong to something else

/// The direction at azimuth and elevation in the LiDAR frame.
Vec3 DirectionAt(double azimuth, double elevation) {
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

struct Tally {
  size_t yes = 0, all = 0;
  void Count(bool hit) {
    yes += hit;
    ++all;
  }
  double Share() const { return all == 0 ? -1.0 : static_cast<double>(yes) / static_cast<double>(all); }
};

core::Pose MidPose(const core::SpinEvent& spin) {
  const double half = 0.5 * static_cast<double>(spin.scan.time_s.empty() ? 0.0f : spin.scan.time_s.back());
  return spin.T_odom_lidar.At(spin.scan.stamp_s + half);
}

}  // namespace

QualityProbes::QualityProbes(const BenchDataset& dataset, const QualityOptions& options)
    : dataset_(dataset), options_(options), oracle_(dataset.scene) {
  const auto [low, high] =
      std::minmax_element(dataset.lidar.elevation_rad.begin(), dataset.lidar.elevation_rad.end());
  elevation_min_ = *low;
  elevation_max_ = *high;
  pitch_rad_ = std::max((elevation_max_ - elevation_min_) / (dataset.lidar.rows() - 1),
                        2.0 * core::kPi / dataset.lidar.columns);
}

void QualityProbes::AddScan(size_t scan) {
  core::Rng rng = core::Rng(options_.seed).Split("scan" + std::to_string(scan));
  const size_t first = probes_.size();
  AddBeamProbes(scan, &rng);
  AddViewProbes(scan, &rng);
  MarkEmpty(first);
}

/// Along the beams that returned: where the noise-free beam ends, and a point before.
void QualityProbes::AddBeamProbes(size_t scan, core::Rng* rng) {
  const core::SpinEvent& spin = dataset_.spins[scan];
  const double diagonal = std::sqrt(3.0) * options_.resolution_m;
  std::vector<core::Ray> rays;
  for (int attempt = 0; attempt < 20 * options_.probes_per_scan; ++attempt) {
    if (static_cast<int>(rays.size()) == options_.probes_per_scan) break;
    const auto i = static_cast<size_t>(rng->UniformInt(static_cast<int>(spin.scan.size())));
    if (spin.scan.kind[i] != core::ReturnKind::kHit || spin.scan.range_m[i] > options_.max_range_m) continue;
    const core::Pose T = spin.T_odom_lidar.At(spin.scan.stamp_s + spin.scan.time_s[i]);
    rays.push_back({T.translation().cast<float>(),
                    (T.linear() * spin.scan.direction_lidar[i].cast<double>()).cast<float>()});
  }
  std::vector<sim::RayHit> hits(rays.size());
  oracle_.CastStatic(rays, static_cast<float>(options_.max_range_m), 1, hits);
  for (size_t k = 0; k < rays.size(); ++k) {
    const float range = hits[k].range_m;
    if (range < 0.0f) continue;
    probes_.push_back({rays[k].origin + range * rays[k].direction, Kind::kHit, range, 0.0f, false, false});
    const double last = range - diagonal;
    if (last <= 0.5) continue;
    const auto at = static_cast<float>(rng->Uniform(0.5, last));
    probes_.push_back({rays[k].origin + at * rays[k].direction, Kind::kFreeOnRay, at, 0.0f, false, false});
  }
}

/// In directions that no beam need have taken: a point before the surface, the surface itself, and how far it
/// goes on around.
void QualityProbes::AddViewProbes(size_t scan, core::Rng* rng) {
  const core::Pose T = MidPose(dataset_.spins[scan]);
  const double diagonal = std::sqrt(3.0) * options_.resolution_m;
  const double step = kLargeSpacings * pitch_rad_;
  constexpr std::array<std::pair<int, int>, 9> kAround = {
      {{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {1, -1}, {-1, 1}, {-1, -1}}};
  std::vector<core::Ray> rays;
  for (int i = 0; i < options_.probes_per_scan; ++i) {
    const double azimuth = rng->Uniform(-core::kPi, core::kPi);
    const double elevation = rng->Uniform(elevation_min_, elevation_max_);
    for (const auto& [du, dv] : kAround) {
      rays.push_back({T.translation().cast<float>(),
                      (T.linear() * DirectionAt(azimuth + du * step, elevation + dv * step)).cast<float>()});
    }
  }
  std::vector<sim::RayHit> hits(rays.size());
  oracle_.CastStatic(rays, static_cast<float>(1.5 * options_.max_range_m), 1, hits);
  for (size_t k = 0; k < rays.size(); k += kAround.size()) {
    const sim::RayHit& hit = hits[k];
    if (hit.range_m < 0.0f || hit.range_m > static_cast<float>(options_.max_range_m)) continue;
    const double cosine = std::abs(hit.normal.normalized().dot(rays[k].direction));
    bool large = true;
    for (size_t n = 1; n < kAround.size(); ++n) {
      large &= hits[k + n].range_m > 0.0f &&
               std::abs(hits[k + n].range_m - hit.range_m) < static_cast<float>(kContinuous) * hit.range_m;
    }
    const auto spacing = static_cast<float>(hit.range_m * pitch_rad_);
    // A millimetre inside: a surface in a voxel's face belongs to the side that is solid.
    probes_.push_back({rays[k].origin + (hit.range_m + 1e-3f) * rays[k].direction, Kind::kSurface,
                       hit.range_m, spacing, cosine < std::cos(kGrazing_rad), large});
    const double last = hit.range_m - diagonal;
    if (last <= 0.5) continue;
    const auto at = static_cast<float>(rng->Uniform(0.5, last));
    probes_.push_back({rays[k].origin + at * rays[k].direction, Kind::kFreeBetween, at, 0.0f, false, false});
  }
}

void QualityProbes::MarkEmpty(size_t first) {
  const double side = options_.resolution_m;
  std::vector<core::Ray> diagonals;
  std::vector<size_t> of;
  for (size_t i = first; i < probes_.size(); ++i) {
    if (probes_[i].kind != Kind::kFreeOnRay && probes_[i].kind != Kind::kFreeBetween) continue;
    const Vec3 corner = side * (probes_[i].p.cast<double>() / side).array().floor().matrix();
    for (int k = 0; k < 4; ++k) {
      const Vec3 along(1.0, k & 1 ? -1.0 : 1.0, k & 2 ? -1.0 : 1.0);
      const Vec3 from = corner + side * Vec3(0.0, k & 1 ? 1.0 : 0.0, k & 2 ? 1.0 : 0.0);
      diagonals.push_back({from.cast<float>(), along.normalized().cast<float>()});
      of.push_back(i);
    }
  }
  std::vector<sim::RayHit> hits(diagonals.size());
  oracle_.CastStatic(diagonals, static_cast<float>(std::sqrt(3.0) * side), 1, hits);
  for (size_t k = 0; k < hits.size(); ++k) {
    if (hits[k].range_m >= 0.0f) probes_[of[k]].empty = false;
  }
}

bool QualityProbes::OccupiedWithin(const StateAt& state, const Vec3& p, double radius_m) const {
  const double r = options_.resolution_m;
  const int n = static_cast<int>(std::ceil(radius_m / r));
  for (int z = -n; z <= n; ++z) {
    for (int y = -n; y <= n; ++y) {
      for (int x = -n; x <= n; ++x) {
        if (state(p + r * Vec3(x, y, z)) == CellState::kOccupied) return true;
      }
    }
  }
  return false;
}

MapQuality QualityProbes::Judge(const StateAt& state) const {
  Tally on_rays, on_rays_empty, on_rays_exact, to_30_empty, to_30_exact, near_hit, near, mid, far, to_30,
      freed, freed_grazing, freed_other, lost;
  for (const Probe& probe : probes_) {
    const Vec3 p = probe.p.cast<double>();
    const CellState cell = state(p);
    const bool free = cell == CellState::kFree;
    switch (probe.kind) {
      case Kind::kFreeOnRay:
        on_rays.Count(free);
        on_rays_exact.Count(probe.empty);
        if (probe.empty) on_rays_empty.Count(free);
        break;
      case Kind::kHit:
        near_hit.Count(OccupiedWithin(state, p, options_.resolution_m));
        break;
      case Kind::kFreeBetween:
        (probe.range_m < 10.0f ? near : probe.range_m < 30.0f ? mid : far).Count(free);
        if (probe.range_m < 30.0f) to_30.Count(free);
        if (probe.range_m < 30.0f) to_30_exact.Count(probe.empty);
        if (probe.range_m < 30.0f && probe.empty) to_30_empty.Count(free);
        break;
      case Kind::kSurface:
        freed.Count(free);
        (probe.grazing ? freed_grazing : freed_other).Count(free);
        if (probe.large) {
          const double radius = std::max<double>(options_.resolution_m, probe.spacing_m);
          lost.Count(free && !OccupiedWithin(state, p, radius));
        }
        break;
    }
  }
  return {.free_on_rays = on_rays.Share(),
          .free_on_rays_empty = on_rays_empty.Share(),
          .free_on_rays_exact = on_rays_exact.Share(),
          .occupied_near_hit = near_hit.Share(),
          .free_between_near = near.Share(),
          .free_between_mid = mid.Share(),
          .free_between_far = far.Share(),
          .free_between_30 = to_30.Share(),
          .free_between_30_empty = to_30_empty.Share(),
          .free_between_30_exact = to_30_exact.Share(),
          .surface_freed = freed.Share(),
          .surface_freed_grazing = freed_grazing.Share(),
          .surface_freed_other = freed_other.Share(),
          .obstacle_freed = lost.Share()};
}

}  // namespace atlas::experiments
