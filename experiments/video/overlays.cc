#include "experiments/video/overlays.h"

#include <unordered_set>

namespace atlas::experiments {
namespace {

using core::Vec3f;
using sim::ColoredMesh;
using sim::Rgb;

struct KeyHash {
  size_t operator()(const Eigen::Vector3i& k) const {
    return static_cast<size_t>(k.x()) * 73856093u ^ static_cast<size_t>(k.y()) * 19349663u ^
           static_cast<size_t>(k.z()) * 83492791u;
  }
};

void AddQuad(ColoredMesh* out, const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& d,
             const Rgb& rgb) {
  const auto n = static_cast<uint32_t>(out->mesh.vertices.size());
  out->mesh.vertices.insert(out->mesh.vertices.end(), {a, b, c, d});
  out->mesh.triangles.push_back({n, n + 1, n + 2});
  out->mesh.triangles.push_back({n, n + 2, n + 3});
  out->rgb.insert(out->rgb.end(), 2, rgb);
}

/// A fan of `sides` triangles about `center` in the plane z = center.z.
void AddDisc(ColoredMesh* out, const Vec3f& center, float radius, int sides, const Rgb& rgb) {
  for (int i = 0; i < sides; ++i) {
    const auto rim = [&](int k) {
      const auto angle = static_cast<float>(2.0 * core::kPi * k / sides);
      return Vec3f(center + radius * Vec3f(std::cos(angle), std::sin(angle), 0.0f));
    };
    const auto n = static_cast<uint32_t>(out->mesh.vertices.size());
    out->mesh.vertices.insert(out->mesh.vertices.end(), {center, rim(i), rim(i + 1)});
    out->mesh.triangles.push_back({n, n + 1, n + 2});
    out->rgb.push_back(rgb);
  }
}

/// A rod of square section from x = 0 and a pyramid at its end, at height `z`.
void AddArrow(ColoredMesh* out, float z, float length, float half_width, const Rgb& rgb) {
  const float neck = 0.65f * length, head = 2.4f * half_width;
  const auto ring = [&](float x, float half, int corner) {
    const float y = corner == 0 || corner == 3 ? -half : half, up = corner < 2 ? -half : half;
    return Vec3f(x, y, z + up);
  };
  const Vec3f tip(length, 0.0f, z);
  for (int corner = 0; corner < 4; ++corner) {
    const int next = (corner + 1) % 4;
    AddQuad(out, ring(0, half_width, corner), ring(neck, half_width, corner), ring(neck, half_width, next),
            ring(0, half_width, next), rgb);
    AddQuad(out, ring(neck, head, corner), tip, tip, ring(neck, head, next), rgb);
    AddQuad(out, ring(neck, half_width, corner), ring(neck, head, corner), ring(neck, head, next),
            ring(neck, half_width, next), rgb);
  }
}

}  // namespace

Rgb HeightColor(double u) {
  constexpr double kStops[5][3] = {
      {40, 70, 190}, {30, 160, 200}, {60, 190, 90}, {240, 200, 50}, {215, 60, 40}};
  const double at = 4.0 * std::clamp(u, 0.0, 1.0);
  const auto i = std::min(static_cast<size_t>(at), size_t{3});
  const double f = at - static_cast<double>(i);
  Rgb rgb;
  for (size_t k = 0; k < 3; ++k)
    rgb[k] = static_cast<uint8_t>((1.0 - f) * kStops[i][k] + f * kStops[i + 1][k]);
  return rgb;
}

ColoredMesh VoxelMesh(const std::vector<Vec3f>& centers, double resolution_m, double low_m, double high_m) {
  std::unordered_set<Eigen::Vector3i, KeyHash> keys;
  const auto key_of = [&](const Vec3f& p) -> Eigen::Vector3i {
    return (p.cast<double>() / resolution_m).array().floor().cast<int>();
  };
  for (const Vec3f& p : centers) keys.insert(key_of(p));
  const auto half = static_cast<float>(0.5 * resolution_m);
  ColoredMesh out;
  for (const Vec3f& p : centers) {
    const Rgb rgb = HeightColor((p.z() - low_m) / std::max(high_m - low_m, 1e-6));
    const Eigen::Vector3i key = key_of(p);
    for (int side = 0; side < 6; ++side) {
      const int axis = side / 2, sign = side % 2 == 0 ? 1 : -1;
      if (keys.contains(key + sign * Eigen::Vector3i::Unit(axis))) continue;
      const Vec3f n = static_cast<float>(sign) * half * Vec3f::Unit(axis);
      const Vec3f u = half * Vec3f::Unit((axis + 1) % 3);
      const Vec3f v = static_cast<float>(sign) * half * Vec3f::Unit((axis + 2) % 3);
      AddQuad(&out, p + n - u - v, p + n + u - v, p + n + u + v, p + n - u + v, rgb);
    }
  }
  if (out.rgb.empty()) out.rgb.push_back({0, 0, 0});
  return out;
}

ColoredMesh TubeMesh(const std::vector<core::Vec3>& points, double radius_m, const Rgb& rgb) {
  constexpr int kSides = 6;
  ColoredMesh out{{}, {}};
  for (size_t i = 0; i + 1 < points.size(); ++i) {
    const core::Vec3 along = points[i + 1] - points[i];
    if (along.norm() < 1e-6) continue;
    const core::Vec3 side = along.unitOrthogonal(), other = along.normalized().cross(side);
    const auto rim = [&](const core::Vec3& p, int k) -> Vec3f {
      const double angle = 2.0 * core::kPi * k / kSides;
      return (p + radius_m * (std::cos(angle) * side + std::sin(angle) * other)).cast<float>();
    };
    for (int k = 0; k < kSides; ++k) {
      AddQuad(&out, rim(points[i], k), rim(points[i], k + 1), rim(points[i + 1], k + 1),
              rim(points[i + 1], k), rgb);
    }
  }
  if (out.rgb.empty()) out.rgb.push_back(rgb);
  return out;
}

ColoredMesh ViewMarkerMesh(const Rgb& rgb) {
  ColoredMesh out{{}, {}};
  AddDisc(&out, {0.0f, 0.0f, 0.02f}, 0.35f, 32, rgb);
  AddArrow(&out, 0.45f, 0.7f, 0.035f, rgb);
  return out;
}

}  // namespace atlas::experiments
