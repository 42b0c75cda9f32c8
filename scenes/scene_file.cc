// Users' own scenes (docs/scene_files.md).
#include <fmt/format.h>

#include "core/errors.h"
#include "scenes/build/convex_hull.h"
#include "scenes/build/shapes.h"
#include "scenes/build/triangle_prisms.h"
#include "scenes/catalog.h"
#include "scenes/mesh_import.h"
#include "scenes/solid_test.h"
#include "scenes/yaml_fields.h"

namespace atlas::scenes {
namespace {

using core::Pose;
using core::Vec3;

core::Label ReadLabel(const YamlFields& fields, const std::string& otherwise) {
  const std::string name = fields.Text("label", otherwise);
  if (const auto label = core::LabelFromName(name)) return *label;
  std::vector<std::string> valid;
  for (size_t k = 0; k < core::kLabelCount; ++k) {
    valid.emplace_back(core::InfoOf(static_cast<core::Label>(k)).name);
  }
  fields.Fail("label", core::UnknownName("label", name, valid));
}

Pose ReadPose(const YamlFields& part) {
  Pose T_map_part = Pose::Identity();
  if (!part.Has("pose")) return T_map_part;
  const YamlFields pose = part.Child("pose");
  pose.AllowOnly({"xyz", "rpy_deg"});
  if (pose.Has("xyz")) T_map_part.translation() = pose.Numbers("xyz", 3);
  if (pose.Has("rpy_deg")) {
    const Vec3 rpy = pose.Numbers("rpy_deg", 3) * core::Radians(1.0);
    T_map_part.linear() = core::RotationFromYawPitchRoll(rpy.z(), rpy.y(), rpy.x());
  }
  return T_map_part;
}

std::vector<CollisionShape> MeshCollision(const YamlFields& fields, const std::string& kind,
                                          const core::TriMesh& mesh) {
  const PrismOptions options;
  if (kind == "none" || mesh.Bounds().min.z() >= options.reach_z_m) return {};
  constexpr size_t kMostForConvexTest = 3000;
  const bool as_hull =
      kind == "hull" || (kind == "auto" && mesh.triangles.size() <= kMostForConvexTest && IsConvex(mesh));
  if (!as_hull) return TrianglePrisms(mesh, options);
  core::TriMesh hull = ConvexHull(mesh.vertices);
  if (hull.triangles.empty()) fields.Fail("collision", "hull: the mesh is flat and has no hull (use prisms)");
  return {{HullShape{std::move(hull)}, Pose::Identity()}};
}

void ReadMesh(const YamlFields& fields, ScenePart& part) {
  fields.AllowOnly({"mesh", "scale", "pose", "label", "name", "object", "collision"});
  const std::filesystem::path given = fields.Text("mesh");
  const std::filesystem::path path = given.is_absolute() ? given : fields.file().parent_path() / given;
  part.name = fields.Text("name", given.stem().string());
  const double scale = fields.Has("scale") ? fields.Positive("scale") : 1.0;
  const std::string kind = fields.Text("collision", "auto");
  const std::vector<std::string> kinds = {"auto", "none", "prisms", "hull"};
  if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) {
    fields.Fail("collision", core::UnknownName("collision", kind, kinds));
  }
  try {
    part.mesh = ImportMesh(path, scale);
  } catch (const core::InputError& error) {
    fields.Fail("mesh", error.what());
  }
  part.mesh.Transform(ReadPose(fields));
  part.collision = MeshCollision(fields, kind, part.mesh);
}

void ReadPrimitive(const YamlFields& fields, ScenePart& part) {
  const std::string kind = fields.Text("primitive");
  const std::vector<std::string> kinds = {"box", "cylinder", "sphere", "capsule"};
  if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) {
    fields.Fail("primitive", core::UnknownName("primitive", kind, kinds));
  }
  std::vector<std::string> keys = {"primitive", "pose", "label", "name", "object"};
  if (kind == "box") keys.push_back("size");
  if (kind != "box") keys.push_back("radius");
  if (kind == "cylinder" || kind == "capsule") keys.push_back("height");
  fields.AllowOnly(keys);
  part.name = fields.Text("name", kind);
  const Pose T = ReadPose(fields);
  if (kind == "box") {
    const Vec3 half_size = 0.5 * fields.Numbers("size", 3);
    if (!(half_size.minCoeff() > 0.0)) fields.Fail("size", "every size must be above 0");
    part.mesh = MakeBox(half_size, T);
    part.collision = {{BoxShape{half_size}, T}};
    return;
  }
  const double radius = fields.Positive("radius");
  if (kind == "sphere") {
    part.mesh = MakeSphere(radius, T);
    part.collision = {{SphereShape{radius}, T}};
    return;
  }
  const double half_height = 0.5 * fields.Positive("height");
  if (kind == "cylinder") {
    part.mesh = MakeCylinder(radius, half_height, T, 32);
    part.collision = {{CylinderShape{radius, half_height}, T}};
    return;
  }
  if (half_height <= radius)
    fields.Fail("height", "a capsule's height (caps included) must exceed twice its radius");
  part.mesh = MakeCapsule(radius, half_height - radius, T, 24);
  part.collision = {{CapsuleShape{radius, half_height - radius}, T}};
}

ScenePart ReadPart(const YamlFields& fields) {
  ScenePart part;
  if (fields.Has("mesh") == fields.Has("primitive")) {
    fields.Fail("", "a part needs either 'mesh' or 'primitive'");
  }
  fields.Has("mesh") ? ReadMesh(fields, part) : ReadPrimitive(fields, part);
  part.label = ReadLabel(fields, "object");
  part.is_object = fields.Flag("object", true);
  return part;
}

/// A slab whose top is the plane z = 0.
ScenePart ReadGround(const YamlFields& scene) {
  constexpr double kHalfThickness_m = 0.25;
  ScenePart ground;
  ground.name = "ground";
  ground.label = core::Label::kGround;
  Vec3 half_size(15.0, 15.0, kHalfThickness_m), centre(0.0, 0.0, -kHalfThickness_m);
  if (scene.Has("ground")) {
    const YamlFields fields = scene.Child("ground");
    fields.AllowOnly({"size", "center", "label"});
    if (fields.Has("size")) half_size.head<2>() = 0.5 * fields.Numbers("size", 2);
    if (!(half_size.minCoeff() > 0.0)) fields.Fail("size", "both sizes must be above 0");
    if (fields.Has("center")) centre.head<2>() = fields.Numbers("center", 2);
    ground.label = ReadLabel(fields, "ground");
  }
  ground.mesh = MakeBox(half_size, core::MakePose(core::Mat3::Identity(), centre));
  ground.collision = {{BoxShape{half_size}, core::MakePose(core::Mat3::Identity(), centre)}};
  return ground;
}

core::Box3 ReadBox(const YamlFields& fields) {
  fields.AllowOnly({"min", "max"});
  const core::Box3 box{fields.Numbers("min", 3), fields.Numbers("max", 3)};
  for (int k = 0; k < 3; ++k) {
    if (box.min[k] < box.max[k]) continue;
    fields.Fail("min",
                fmt::format("{} = {} is not below max {} = {}", "xyz"[k], box.min[k], "xyz"[k], box.max[k]));
  }
  return box;
}

void CheckSpawn(const YamlFields& spawn, const SceneSpec& scene, const core::Box3& ground) {
  const Vec3 p = scene.T_map_spawn.translation();
  if (!ground.Contains(Vec3(p.x(), p.y(), ground.max.z()))) {
    spawn.Fail("", fmt::format("({}, {}) lies outside the ground (x {} to {}, y {} to {})", p.x(), p.y(),
                               ground.min.x(), ground.max.x(), ground.min.y(), ground.max.y()));
  }
  for (const ScenePart& part : scene.parts) {
    if (part.name == "ground" || !IsWatertight(part.mesh)) continue;
    const SolidTest solid({&part.mesh});
    for (double z : {0.1, 0.3, 0.5, 0.7}) {
      if (solid.IsInside(p + Vec3(0, 0, z)))
        spawn.Fail("", fmt::format("({}, {}) lies inside part '{}'", p.x(), p.y(), part.name));
    }
  }
}

void CheckObject(const YamlFields& fields, const SceneSpec& scene) {
  bool any = false, inside = false;
  for (const ScenePart& part : scene.parts) {
    if (!part.is_object) continue;
    any = true;
    for (const core::Vec3f& v : part.mesh.vertices)
      inside = inside || scene.object_box.Contains(v.cast<double>());
    const core::Box3 box = part.mesh.Bounds(), &object = scene.object_box;
    const bool apart =
        (box.min.array() > object.max.array()).any() || (box.max.array() < object.min.array()).any();
    inside = inside || !apart;
  }
  if (!any) fields.Fail("parts", "no part is the object (object: true)");
  if (!inside) fields.Fail("object_box", "holds no part of the object");
}

/// Of a space the robot sees the inside.
void CheckInside(const YamlFields& fields, const SceneSpec& scene) {
  const Vec3 p = scene.T_map_spawn.translation();
  const core::Box3& box = scene.object_box;
  if ((p.head<2>().array() > box.min.head<2>().array()).all() &&
      (p.head<2>().array() < box.max.head<2>().array()).all()) {
    return;
  }
  fields.Fail("object_box",
              fmt::format("({}, {}), where the robot starts, lies outside of the space", p.x(), p.y()));
}

}  // namespace

SceneSpec LoadSceneFile(const std::filesystem::path& path) {
  const YamlFields fields = YamlFields::FromFile(path);
  fields.AllowOnly({"name", "doc", "spawn", "object_box", "space", "ground", "parts"});
  SceneSpec scene;
  scene.name = fields.Text("name", path.stem().string());
  scene.doc = fields.Prose("doc", "scene of " + path.filename().string());

  const YamlFields spawn = fields.Child("spawn");
  spawn.AllowOnly({"x", "y", "yaw_deg"});
  scene.T_map_spawn = core::PoseFromXyzYaw(Vec3(spawn.Number("x"), spawn.Number("y"), 0.0),
                                           core::Radians(spawn.Number("yaw_deg", 0.0)));
  scene.object_box = ReadBox(fields.Child("object_box"));
  scene.is_space = fields.Flag("space", false);

  scene.parts.push_back(ReadGround(fields));
  const core::Box3 ground = scene.parts.front().mesh.Bounds();
  for (const YamlFields& part : fields.Children("parts")) scene.parts.push_back(ReadPart(part));
  for (const ScenePart& part : scene.parts) {
    const core::Box3 box = part.mesh.Bounds();
    scene.bounds.Extend(box.min);
    scene.bounds.Extend(box.max);
  }
  CheckSpawn(spawn, scene, ground);
  if (scene.is_space) CheckInside(fields, scene);
  CheckObject(fields, scene);
  return scene;
}

}  // namespace atlas::scenes
