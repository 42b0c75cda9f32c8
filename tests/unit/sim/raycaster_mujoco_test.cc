// The raycaster against MuJoCo's own rays on primitives.
//
// Boxes are the same surfaces in both. Spheres, cylinders and capsules are exact in MuJoCo and meshes here:
// 256 segments keep the mesh within r (1 - cos(pi / 256)) = 0.08 mm of the radius, which a ray that grazes
// the surface at less than 4 degrees still turns into more than 1 mm; such rays are about one in a thousand
// hits on a round shape.
#include <gtest/gtest.h>

#include <mujoco/mujoco.h>
#include "tests/support/sensor_scenes.h"

#include <cstring>
#include <sstream>

#include "sim/sensors/raycaster.h"

namespace atlas::sim {
namespace {

using namespace testing;  // NOLINT

constexpr int kSegments = 256;

struct World {
  scenes::SceneSpec scene;
  std::ostringstream mjcf;
};

void AddGeom(World* world, const char* type, const core::Pose& T, const std::string& size,
             core::TriMesh mesh) {
  const Eigen::Quaterniond q(T.linear());
  world->mjcf.precision(17);
  world->mjcf << "<geom type='" << type << "' size='" << size << "' pos='" << T.translation().transpose()
              << "' quat='" << q.w() << " " << q.x() << " " << q.y() << " " << q.z() << "'/>\n";
  world->scene.parts.push_back(Part(std::move(mesh)));
}

core::TriMesh CapsuleMesh(double radius, double half_length, const core::Pose& T) {
  std::vector<core::Vec2> profile;
  for (int i = 0; i <= kSegments / 2; ++i) {
    const double angle = 2.0 * core::kPi * i / kSegments;
    const double z = -radius * std::cos(angle);
    profile.emplace_back(radius * std::sin(angle), z + (2 * i <= kSegments / 2 ? -half_length : half_length));
  }
  return LatheMesh(profile, kSegments, T);
}

World RandomWorld(core::Rng* rng, bool round_shapes) {
  World world;
  for (int i = 0; i < 40; ++i) {
    const core::Vec3 half(rng->Uniform(0.05, 1.0), rng->Uniform(0.05, 1.0), rng->Uniform(0.05, 1.0));
    const core::Pose T = RandomPose(rng, 4.0);
    std::ostringstream size;
    size.precision(17);
    size << half.transpose();
    AddGeom(&world, "box", T, size.str(), BoxMesh(half, T));
  }
  for (int i = 0; round_shapes && i < 12; ++i) {
    const double radius = rng->Uniform(0.2, 0.8), half_length = rng->Uniform(0.2, 1.0);
    const core::Pose T = RandomPose(rng, 4.0);
    std::ostringstream size;
    size.precision(17);
    size << radius << " " << half_length;
    if (i % 3 == 0) AddGeom(&world, "sphere", T, size.str(), SphereMesh(radius, kSegments, T));
    if (i % 3 == 1)
      AddGeom(&world, "cylinder", T, size.str(), CylinderMesh(radius, half_length, kSegments, T));
    if (i % 3 == 2) AddGeom(&world, "capsule", T, size.str(), CapsuleMesh(radius, half_length, T));
  }
  return world;
}

struct MujocoModel {
  mjModel* model = nullptr;
  mjData* data = nullptr;

  explicit MujocoModel(const std::string& geoms) {
    const std::string xml = "<mujoco><worldbody>" + geoms + "</worldbody></mujoco>";
    const auto vfs = std::make_unique<mjVFS>();
    mj_defaultVFS(vfs.get());
    mj_makeEmptyFileVFS(vfs.get(), "world.xml", static_cast<int>(xml.size()));
    std::memcpy(vfs->filedata[0], xml.data(), xml.size());
    char error[512] = "";
    model = mj_loadXML("world.xml", vfs.get(), error, sizeof error);
    mj_deleteVFS(vfs.get());
    if (model == nullptr) throw std::runtime_error(error);
    data = mj_makeData(model);
    mj_forward(model, data);
  }
  ~MujocoModel() {
    mj_deleteData(data);
    mj_deleteModel(model);
  }
  double Range(const core::Ray& ray) const {
    const core::Vec3 origin = ray.origin.cast<double>(), direction = ray.direction.cast<double>();
    int geom = -1;
    return mj_ray(model, data, origin.data(), direction.data(), nullptr, 1, -1, &geom);
  }
};

/// Share of 10,000 rays whose ranges agree within 1 mm (or that both meet nothing).
double ShareThatAgrees(uint64_t seed, bool round_shapes) {
  core::Rng rng(seed);
  const World world = RandomWorld(&rng, round_shapes);
  const MujocoModel mujoco(world.mjcf.str());
  const Raycaster raycaster(world.scene);
  const std::vector<core::Ray> rays = RandomRays(&rng, 10000, 4.0);
  std::vector<RayHit> hits(rays.size());
  raycaster.Cast(rays, 100.0f, 1, 1, hits);
  size_t agree = 0, hit_count = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    const double range = mujoco.Range(rays[i]);
    const bool both_miss = range < 0.0 && hits[i].range_m < 0.0f;
    agree += both_miss || (range >= 0.0 && std::abs(range - hits[i].range_m) < 1e-3) ? 1 : 0;
    hit_count += range >= 0.0 ? 1 : 0;
  }
  EXPECT_GT(hit_count, 3000u);
  return static_cast<double>(agree) / static_cast<double>(rays.size());
}

TEST(RaycasterMujocoTest, BoxesAgreeWithMujocoRays) {
  EXPECT_GE(ShareThatAgrees(1, false), 0.9995);
}

TEST(RaycasterMujocoTest, RoundShapesAgreeWithMujocoRays) {
  EXPECT_GE(ShareThatAgrees(2, true), 0.999);
}

}  // namespace
}  // namespace atlas::sim
