#include "planner/gain/ray_directions.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/rng.h"

namespace atlas::planner {
namespace {

using core::Box3;
using core::Vec3;

constexpr double kOuterDensity = 0.5;  ///< of the elevations that only some headings see
constexpr double kTrialSpacing_rad = 0.03;
constexpr double kFinestSpacing_rad = 2e-4;
constexpr int kMostRefinements = 8;
constexpr uint64_t kJitterSeed = 0x5eed;

struct Interval {
  double min = 0.0, max = 0.0;
  double Width() const { return std::max(0.0, max - min); }
};

/// Bounding azimuths and elevations of the box seen from the origin.
struct AngularBounds {
  Interval azimuth, elevation;
};

AngularBounds BoundsOf(const Box3& box, const Vec3& origin) {
  const Vec3 nearest = origin.cwiseMax(box.min).cwiseMin(box.max);
  const double near_m = (nearest - origin).head<2>().norm();
  const Vec3 centre = box.Center();
  const double bearing = std::atan2(centre.y() - origin.y(), centre.x() - origin.x());
  AngularBounds bounds;
  double far_m = 0.0;
  bounds.azimuth = {bearing, bearing};
  for (const double x : {box.min.x(), box.max.x()}) {
    for (const double y : {box.min.y(), box.max.y()}) {
      const double dx = x - origin.x(), dy = y - origin.y();
      far_m = std::max(far_m, std::hypot(dx, dy));
      const double azimuth = bearing + core::WrapAngle(std::atan2(dy, dx) - bearing);
      bounds.azimuth.min = std::min(bounds.azimuth.min, azimuth);
      bounds.azimuth.max = std::max(bounds.azimuth.max, azimuth);
    }
  }
  if (near_m <= 0.0) bounds.azimuth = {-core::kPi, core::kPi};
  const double up = box.max.z() - origin.z(), down = box.min.z() - origin.z();
  bounds.elevation = {std::atan2(down, down < 0.0 ? near_m : far_m),
                      std::atan2(up, up > 0.0 ? near_m : far_m)};
  return bounds;
}

class Sampler {
 public:
  Sampler(const Box3& box, const Vec3& origin, const SweepView& view, double max_range_m)
      : box_(box), origin_(origin), max_range_m_(max_range_m), bounds_(BoundsOf(box, origin)) {
    const Interval all = Clip({view.elevation_min_rad(), view.elevation_max_rad()}, bounds_.elevation);
    common_ = Clip({view.common_elevation_min_rad(), view.common_elevation_max_rad()}, all);
    below_ = {all.min, std::min(all.max, view.common_elevation_min_rad())};
    above_ = {std::max(all.min, view.common_elevation_max_rad()), all.max};
  }

  /// All directions at this spacing; `in_common` receives how many lie in the common elevations.
  std::vector<RayDirection> Sample(double spacing_rad, size_t* in_common) const {
    std::vector<RayDirection> directions;
    FillBand(common_, spacing_rad, &directions);
    *in_common = directions.size();
    FillBand(below_, spacing_rad / std::sqrt(kOuterDensity), &directions);
    FillBand(above_, spacing_rad / std::sqrt(kOuterDensity), &directions);
    return directions;
  }

 private:
  static Interval Clip(const Interval& a, const Interval& b) {
    return {std::max(a.min, b.min), std::min(a.max, b.max)};
  }

  void FillBand(const Interval& band, double spacing_rad, std::vector<RayDirection>* out) const {
    if (band.Width() <= 0.0) return;
    const int rows = std::max(1, static_cast<int>(std::ceil(band.Width() / spacing_rad)));
    const double height = band.Width() / rows;
    for (int row = 0; row < rows; ++row) {
      const Interval elevation{band.min + row * height, band.min + (row + 1) * height};
      FillRow(elevation, spacing_rad, out);
    }
  }

  void FillRow(const Interval& elevation, double spacing_rad, std::vector<RayDirection>* out) const {
    const double width = bounds_.azimuth.Width();
    const double middle = 0.5 * (elevation.min + elevation.max);
    const int columns = std::max(1, static_cast<int>(std::ceil(width * std::cos(middle) / spacing_rad)));
    // The exact solid angle of a cell between two elevations.
    const double solid_angle = width / columns * (std::sin(elevation.max) - std::sin(elevation.min));
    for (int column = 0; column < columns; ++column) {
      const uint64_t cell = (static_cast<uint64_t>(middle * 1e7 + 1e8) << 20) + static_cast<uint64_t>(column);
      const double u = core::UniformAt(kJitterSeed, 2 * cell), v = core::UniformAt(kJitterSeed, 2 * cell + 1);
      const double azimuth = bounds_.azimuth.min + width * (column + u) / columns;
      const double e = elevation.min + elevation.Width() * v;
      const Vec3 d(std::cos(e) * std::cos(azimuth), std::cos(e) * std::sin(azimuth), std::sin(e));
      const auto inside = box_.Clip(origin_, d);
      if (!inside || inside->first > max_range_m_) continue;
      out->push_back({d, azimuth, e, solid_angle});
    }
  }

  Box3 box_;
  Vec3 origin_;
  double max_range_m_;
  AngularBounds bounds_;
  Interval common_, below_, above_;
};

}  // namespace

std::vector<RayDirection> DirectionsInto(const Box3& object_box, const Vec3& origin_map,
                                         const SweepView& view, int rays, double max_range_m) {
  const Sampler sampler(object_box, origin_map, view, max_range_m);
  double spacing = kTrialSpacing_rad;
  std::vector<RayDirection> directions;
  for (int attempt = 0; attempt < kMostRefinements; ++attempt) {
    size_t in_common = 0;
    directions = sampler.Sample(spacing, &in_common);
    const size_t counted = in_common > 0 ? in_common : directions.size();
    const bool enough = counted >= static_cast<size_t>(rays);
    if (enough && (attempt > 0 || counted < 2 * static_cast<size_t>(rays))) break;
    if (spacing <= kFinestSpacing_rad) break;
    if (counted == 0) {
      spacing *= 0.25;  // the box may be smaller than a cell
      continue;
    }
    spacing *= 0.985 * std::sqrt(static_cast<double>(counted) / rays);
    spacing = std::max(spacing, kFinestSpacing_rad);
  }
  return directions;
}

}  // namespace atlas::planner
