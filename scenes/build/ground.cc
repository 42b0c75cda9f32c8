#include "scenes/build/ground.h"

#include "core/rng.h"

namespace atlas::scenes {
namespace {

using core::Vec2;
using core::Vec3;

constexpr uint64_t kGrassSeed = 20210307;

/// Bilinear value noise in [-1, 1] with smooth steps between lattice values.
double ValueNoise(double x, double y, uint64_t seed) {
  const auto value = [&](double i, double j) {
    const auto index = static_cast<uint64_t>(static_cast<int64_t>(i) * 1000003 + static_cast<int64_t>(j));
    return 2.0 * core::UniformAt(seed, index) - 1.0;
  };
  const double i = std::floor(x), j = std::floor(y);
  const double u = (x - i) * (x - i) * (3 - 2 * (x - i)), v = (y - j) * (y - j) * (3 - 2 * (y - j));
  return (1 - v) * ((1 - u) * value(i, j) + u * value(i + 1, j)) +
         v * ((1 - u) * value(i, j + 1) + u * value(i + 1, j + 1));
}

}  // namespace

void AddFlatGround(SceneBuilder& scene, const Rect& extent, core::Label label) {
  constexpr double kThickness_m = 0.5;
  scene.Box({"ground", label}, Vec3(extent.min.x(), extent.min.y(), -kThickness_m),
            Vec3(extent.max.x(), extent.max.y(), 0.0));
}

void AddRoughGrass(SceneBuilder& scene, const Rect& extent, double amplitude_m, const Vec2& flat) {
  HeightGridShape grid;
  grid.spacing_m = 0.125;
  grid.origin = extent.min;
  grid.cols = static_cast<int>(std::lround((extent.max.x() - extent.min.x()) / grid.spacing_m)) + 1;
  grid.rows = static_cast<int>(std::lround((extent.max.y() - extent.min.y()) / grid.spacing_m)) + 1;
  for (int row = 0; row < grid.rows; ++row) {
    for (int col = 0; col < grid.cols; ++col) {
      const Vec2 p = grid.origin + grid.spacing_m * Vec2(col, row);
      const double bumps = 0.65 * ValueNoise(p.x() / 0.9, p.y() / 0.9, kGrassSeed) +
                           0.35 * ValueNoise(p.x() / 0.4, p.y() / 0.4, kGrassSeed + 1);
      const double fade = std::clamp(((p - flat).norm() - 0.7) / 0.6, 0.0, 1.0);
      grid.height_m.push_back(static_cast<float>(amplitude_m * fade * bumps));
    }
  }
  const Paint grass{"grass", core::Label::kGrass};
  scene.Visual(grass, MakeHeightGridSolid(grid, -0.5));
  scene.Collide(grass, {std::move(grid), core::Pose::Identity()});
}

core::TriMesh MakeHeightGridSolid(const HeightGridShape& grid, double bottom) {
  core::TriMesh mesh;
  const auto place = [&](int row, int col, float z) {
    const Vec2 p = grid.origin + grid.spacing_m * Vec2(col, row);
    mesh.vertices.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), z);
    return static_cast<uint32_t>(mesh.vertices.size() - 1);
  };
  for (int row = 0; row < grid.rows; ++row) {
    for (int col = 0; col < grid.cols; ++col) {
      place(row, col, grid.height_m[static_cast<size_t>(row) * grid.cols + col]);
    }
  }
  const auto top = [&](int row, int col) { return static_cast<uint32_t>(row * grid.cols + col); };
  for (int row = 0; row + 1 < grid.rows; ++row) {
    for (int col = 0; col + 1 < grid.cols; ++col) {
      mesh.triangles.push_back({top(row, col), top(row, col + 1), top(row + 1, col + 1)});
      mesh.triangles.push_back({top(row, col), top(row + 1, col + 1), top(row + 1, col)});
    }
  }
  // The rim, counter-clockwise from above, hung down to the bottom and closed there by a fan.
  std::vector<std::pair<int, int>> rim;
  for (int col = 0; col + 1 < grid.cols; ++col) rim.emplace_back(0, col);
  for (int row = 0; row + 1 < grid.rows; ++row) rim.emplace_back(row, grid.cols - 1);
  for (int col = grid.cols - 1; col > 0; --col) rim.emplace_back(grid.rows - 1, col);
  for (int row = grid.rows - 1; row > 0; --row) rim.emplace_back(row, 0);
  const auto first = static_cast<uint32_t>(mesh.vertices.size()), n = static_cast<uint32_t>(rim.size());
  for (const auto& [row, col] : rim) place(row, col, static_cast<float>(bottom));
  const Vec2 middle = 0.5 * grid.spacing_m * Vec2(grid.cols - 1, grid.rows - 1) + grid.origin;
  mesh.vertices.emplace_back(static_cast<float>(middle.x()), static_cast<float>(middle.y()),
                             static_cast<float>(bottom));
  for (uint32_t j = 0; j < n; ++j) {
    const uint32_t k = (j + 1) % n;
    const uint32_t a = top(rim[j].first, rim[j].second), b = top(rim[k].first, rim[k].second);
    mesh.triangles.push_back({a, first + j, first + k});
    mesh.triangles.push_back({a, first + k, b});
    mesh.triangles.push_back({first + n, first + k, first + j});
  }
  return mesh;
}

}  // namespace atlas::scenes
