#include "sim/world/world_mjcf.h"

#include <fmt/format.h>

#include <map>
#include <tuple>

#include "core/errors.h"
#include "robots/robot_files.h"

namespace atlas::sim {
namespace {

constexpr double kTileM = 2.5;

std::string Numbers(const core::Vec3& v) {
  return fmt::format("{:.9g} {:.9g} {:.9g}", v.x(), v.y(), v.z());
}

std::string PoseAttributes(const core::Pose& T) {
  const Eigen::Quaterniond q(T.linear());
  return fmt::format("pos=\"{}\" quat=\"{:.12g} {:.12g} {:.12g} {:.12g}\"", Numbers(T.translation()), q.w(),
                     q.x(), q.y(), q.z());
}

/// The height field's geom sits at the middle of its grid, at its lowest height.
core::Pose HeightFieldPose(const scenes::HeightGridShape& grid, const core::Pose& T_map_shape) {
  const auto [low, high] = std::minmax_element(grid.height_m.begin(), grid.height_m.end());
  const core::Vec2 half(0.5 * (grid.cols - 1) * grid.spacing_m, 0.5 * (grid.rows - 1) * grid.spacing_m);
  const core::Vec2 middle = grid.origin + half;
  return T_map_shape * Eigen::Translation3d(middle.x(), middle.y(), *low);
}

struct Writer {
  std::string assets;
  std::map<std::tuple<int, int, int>, std::string> tiles;  ///< geoms of each static body

  void Add(const std::string& name, const scenes::CollisionShape& collision);
  void Geom(const std::string& name, const core::Pose& T, const std::string& attributes);
};

void Writer::Geom(const std::string& name, const core::Pose& T, const std::string& attributes) {
  const core::Vec3 p = T.translation() / kTileM;
  const auto tile = [](double x) { return static_cast<int>(std::floor(x)); };
  tiles[{tile(p.x()), tile(p.y()), tile(p.z())}] += fmt::format(
      "<geom name=\"{}\" {} {} contype=\"2\" conaffinity=\"1\" group=\"0\" condim=\"3\" "
      "friction=\"1 0.005 0.0001\"/>\n",
      name, attributes, PoseAttributes(T));
}

void Writer::Add(const std::string& name, const scenes::CollisionShape& collision) {
  const core::Pose& T = collision.T_map_shape;
  if (const auto* box = std::get_if<scenes::BoxShape>(&collision.shape)) {
    Geom(name, T, fmt::format("type=\"box\" size=\"{}\"", Numbers(box->half_size)));
  } else if (const auto* cylinder = std::get_if<scenes::CylinderShape>(&collision.shape)) {
    Geom(name, T, fmt::format("type=\"cylinder\" size=\"{} {}\"", cylinder->radius, cylinder->half_length));
  } else if (const auto* capsule = std::get_if<scenes::CapsuleShape>(&collision.shape)) {
    Geom(name, T, fmt::format("type=\"capsule\" size=\"{} {}\"", capsule->radius, capsule->half_length));
  } else if (const auto* sphere = std::get_if<scenes::SphereShape>(&collision.shape)) {
    Geom(name, T, fmt::format("type=\"sphere\" size=\"{}\"", sphere->radius));
  } else if (const auto* hull = std::get_if<scenes::HullShape>(&collision.shape)) {
    std::string vertices;
    for (const core::Vec3f& v : hull->mesh.vertices) vertices += Numbers(v.cast<double>()) + " ";
    assets += fmt::format("<mesh name=\"{}\" vertex=\"{}\"/>\n", name, vertices);
    Geom(name, T, fmt::format("type=\"mesh\" mesh=\"{}\"", name));
  } else {
    const auto& grid = std::get<scenes::HeightGridShape>(collision.shape);
    const auto [low, high] = std::minmax_element(grid.height_m.begin(), grid.height_m.end());
    assets += fmt::format("<hfield name=\"{}\" nrow=\"{}\" ncol=\"{}\" size=\"{} {} {} 0.5\"/>\n", name,
                          grid.rows, grid.cols, 0.5 * (grid.cols - 1) * grid.spacing_m,
                          0.5 * (grid.rows - 1) * grid.spacing_m, std::max<double>(*high - *low, 1e-3));
    Geom(name, HeightFieldPose(grid, T), fmt::format("type=\"hfield\" hfield=\"{}\"", name));
  }
}

std::string WhatIsWrong(const scenes::HeightGridShape& grid) {
  const bool sized = grid.rows >= 2 && grid.cols >= 2 && grid.spacing_m > 0.0 &&
                     grid.height_m.size() == static_cast<size_t>(grid.rows) * static_cast<size_t>(grid.cols);
  if (sized) return "";
  return fmt::format("height grid {} x {} with {} heights, {} m apart", grid.rows, grid.cols,
                     grid.height_m.size(), grid.spacing_m);
}

/// The hull algorithm aborts on flat sets of points, so they are found beforehand.
std::string WhatIsWrong(const scenes::HullShape& hull) {
  constexpr double kFlatM = 1e-5;
  core::Vec3 mean = core::Vec3::Zero();
  for (const core::Vec3f& v : hull.mesh.vertices) mean += v.cast<double>();
  mean /= std::max<double>(1.0, static_cast<double>(hull.mesh.vertices.size()));
  core::Mat3 spread = core::Mat3::Zero();
  for (const core::Vec3f& v : hull.mesh.vertices) {
    const core::Vec3 d = v.cast<double>() - mean;
    spread += d * d.transpose();
  }
  const double thinnest = Eigen::SelfAdjointEigenSolver<core::Mat3>(spread).eigenvalues()[0];
  if (hull.mesh.vertices.size() >= 4 && thinnest > kFlatM * kFlatM) return "";
  return fmt::format("convex hull of {} points is flat", hull.mesh.vertices.size());
}

template <typename Shape>
std::string WhatIsWrong(const Shape&) {
  return "";
}

void CheckShape(const scenes::SceneSpec& scene, const scenes::ScenePart& part,
                const scenes::CollisionShape& c) {
  const std::string wrong = std::visit([](const auto& shape) { return WhatIsWrong(shape); }, c.shape);
  if (wrong.empty()) return;
  throw core::InputError(fmt::format("scene {}: part '{}': {}", scene.name, part.name, wrong));
}

}  // namespace

std::string StaticShapeName(size_t part, size_t shape) {
  return fmt::format("static_{}_{}", part, shape);
}

std::string ComposeMjcf(const scenes::SceneSpec& scene, const robots::RobotSpec& robot) {
  Writer writer;
  for (size_t i = 0; i < scene.parts.size(); ++i) {
    for (size_t j = 0; j < scene.parts[i].collision.size(); ++j) {
      CheckShape(scene, scene.parts[i], scene.parts[i].collision[j]);
      writer.Add(StaticShapeName(i, j), scene.parts[i].collision[j]);
    }
  }
  const robots::AssetFolders folders = robots::AssetFoldersOf(robot.mjcf);
  std::string bodies;
  for (const auto& [tile, geoms] : writer.tiles) bodies += fmt::format("<body>\n{}</body>\n", geoms);
  return fmt::format(
      "<mujoco model=\"atlas\">\n<include file=\"{}\"/>\n<compiler angle=\"degree\" autolimits=\"true\" "
      "meshdir=\"{}\" texturedir=\"{}\"/>\n"
      "<option timestep=\"0.002\" gravity=\"0 0 -{}\" cone=\"elliptic\" impratio=\"10\" solver=\"Newton\" "
      "integrator=\"Euler\" iterations=\"30\" tolerance=\"1e-8\"/>\n<size njmax=\"1500\" nconmax=\"300\"/>\n"
      "<asset>\n{}</asset>\n<worldbody>\n{}</worldbody>\n</mujoco>\n",
      std::filesystem::absolute(robot.mjcf).string(), folders.meshes.string(), folders.textures.string(),
      9.81, writer.assets, bodies);
}

}  // namespace atlas::sim
