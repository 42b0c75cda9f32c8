#include "scenes/town/greenery.h"

namespace atlas::scenes {
namespace {

using core::Label;
using core::Rng;
using core::Vec3;

const Paint kTrunk{"trunks", Label::kTree, true};
const Paint kLeaves{"leaves", Label::kTree, true};
const Paint kHedge{"hedges", Label::kTree, true};

core::Mat3 RandomRotation(Rng* rng) {
  Eigen::Quaterniond q(rng->Normal(), rng->Normal(), rng->Normal(), rng->Normal());
  return q.normalized().toRotationMatrix();
}

/// A flattened octahedron: a clump of leaves of `size_m` from tip to tip.
core::TriMesh MakeClump(const Vec3& middle, double size_m, Rng* rng) {
  const core::Mat3 R = RandomRotation(rng);
  const Vec3 half = 0.5 * size_m * Vec3(1.0, rng->Uniform(0.6, 1.0), rng->Uniform(0.15, 0.4));
  core::TriMesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (double sign : {1.0, -1.0}) {
      mesh.vertices.push_back((middle + sign * half[axis] * R.col(axis)).cast<float>());
    }
  }
  for (uint32_t x : {0u, 1u}) {
    for (uint32_t y : {2u, 3u}) {
      for (uint32_t z : {4u, 5u}) {
        const bool flipped = (x + y + z) % 2 == 1;
        mesh.triangles.push_back({x, flipped ? z : y, flipped ? y : z});
      }
    }
  }
  return mesh;
}

/// A tapering round limb through `spine`.
core::TriMesh MakeLimb(const std::vector<Vec3>& spine, double radius_m, double end_share, int corners) {
  std::vector<Ring> rings;
  for (size_t i = 0; i < spine.size(); ++i) {
    const Vec3 along = (spine[std::min(i + 1, spine.size() - 1)] - spine[i > 0 ? i - 1 : 0]).normalized();
    const Vec3 side = along.cross(std::abs(along.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY()).normalized();
    const Vec3 other = along.cross(side);
    const double share = static_cast<double>(i) / static_cast<double>(spine.size() - 1);
    const double r = radius_m * (1.0 + share * (end_share - 1.0));
    Ring ring;
    for (int j = 0; j < corners; ++j) {
      const double a = 2.0 * core::kPi * j / corners;
      ring.push_back(spine[i] + r * (std::cos(a) * side + std::sin(a) * other));
    }
    rings.push_back(ring);
  }
  return MakeLoft(rings);
}

}  // namespace

void AddTree(SceneBuilder& scene, const Vec3& foot, const TreeShape& shape, Rng* rng) {
  const double crown_height = shape.height_m - shape.clear_trunk_m;
  const Vec3 lean(rng->Uniform(-0.06, 0.06), rng->Uniform(-0.06, 0.06), 1.0);
  const Vec3 fork = foot + (shape.clear_trunk_m + 0.15 * crown_height) * lean;
  const Vec3 crown = foot + (shape.clear_trunk_m + 0.5 * crown_height) * lean;
  const Vec3 root = foot - Vec3(0, 0, 0.3);
  scene.Visual(kTrunk, MakeLimb({root, foot + Vec3(0, 0, 0.25), 0.5 * (foot + fork), fork, crown},
                                1.25 * shape.trunk_radius_m, 0.35, 9));
  scene.Collide(kTrunk, {CylinderShape{shape.trunk_radius_m, 1.0}, At(foot + Vec3(0, 0, 1.0))});
  const Vec3 half(shape.crown_radius_m, shape.crown_radius_m, 0.5 * crown_height);
  const int limbs = 5;
  const double turn = rng->Uniform(0.0, core::kPi);
  for (int k = 0; k < limbs; ++k) {
    const double a = turn + 2.0 * core::kPi * k / limbs + rng->Uniform(-0.3, 0.3);
    const Vec3 end =
        crown + half.cwiseProduct(Vec3(0.65 * std::cos(a), 0.65 * std::sin(a), rng->Uniform(-0.3, 0.5)));
    const Vec3 start = fork + rng->Uniform(-0.3, 0.4) * lean;
    scene.Visual(kTrunk, MakeLimb({start, 0.5 * (start + end) + Vec3(0, 0, 0.3), end},
                                  0.4 * shape.trunk_radius_m, 0.3, 6));
  }
  for (int k = 0; k < shape.leaves; ++k) {
    // Denser towards the crown's skin, as foliage is.
    const Vec3 direction = RandomRotation(rng).col(0);
    const double share = std::cbrt(rng->Uniform(0.12, 1.0));
    scene.Visual(kLeaves,
                 MakeClump(crown + share * half.cwiseProduct(direction), rng->Uniform(0.5, 1.0), rng));
  }
}

void AddHedge(SceneBuilder& scene, const Vec3& a, const Vec3& b, double height_m, double width_m, Rng* rng) {
  const Vec3 along = (b - a).normalized();
  const double length = (b - a).norm(), yaw = std::atan2(along.y(), along.x());
  const core::Pose T_map_hedge =
      core::PoseFromXyzYaw(Vec3(0.5 * (a + b) + Vec3(0, 0, 0.5 * height_m - 0.2)), yaw);
  scene.Box(kHedge, Vec3(0.5 * length, 0.5 * width_m - 0.06, 0.5 * height_m + 0.1), T_map_hedge);
  const int clumps = static_cast<int>(15.0 * length);
  for (int k = 0; k < clumps; ++k) {
    const double side = k % 3 == 0 ? 0.0 : k % 3 == 1 ? 0.5 : -0.5;
    const double across = side == 0.0 ? rng->Uniform(-0.5, 0.5) : side;
    const double up = side == 0.0 ? 0.5 * height_m + 0.1 : rng->Uniform(-0.4, 0.5) * height_m;
    const Vec3 p(rng->Uniform(-0.5, 0.5) * length, across * (width_m - 0.1), up);
    scene.Visual(kHedge, MakeClump(T_map_hedge * p, rng->Uniform(0.25, 0.5), rng));
  }
}

}  // namespace atlas::scenes
