#include "scenes/town/interior.h"

#include "core/rng.h"
#include "scenes/build/openings.h"
#include "scenes/town/facade_run.h"

namespace atlas::scenes {
namespace {

using core::Label;
using core::Vec2;
using core::Vec3;

constexpr double kJamb_m = 0.05;

const Paint kInnerWalls{"walls", Label::kWall, true}, kDoorFrames{"door_frames", Label::kDoor, true};

/// Jambs and head of a doorway: the wall's hole is wider by them, so that its size stays clear.
void AddFrame(SceneBuilder& scene, const core::Pose& T_map_wall, const Opening& opening) {
  constexpr double kProud_m = 0.025;
  const double half = 0.5 * opening.width_m, y = 0.5 * kPartition_m + kProud_m;
  const auto box = [&](double x0, double z0, double x1, double z1, Physics physics) {
    WallBox(scene, kDoorFrames, T_map_wall, Vec3(opening.at_m + x0, -y, z0), Vec3(opening.at_m + x1, y, z1),
            physics);
  };
  box(-half - kJamb_m, -0.05, -half, opening.height_m, Physics::kSolid);
  box(half, -0.05, half + kJamb_m, opening.height_m, Physics::kSolid);
  box(-half - kJamb_m, opening.height_m, half + kJamb_m, opening.height_m + kJamb_m, Physics::kNone);
}

}  // namespace

void AddPartition(SceneBuilder& scene, const Storey& storey, const Partition& wall) {
  const Vec2 along = wall.to - wall.from;
  const core::Pose T = core::PoseFromXyzYaw(Vec3(wall.from.x(), wall.from.y(), storey.floor_z),
                                            std::atan2(along.y(), along.x()));
  const double length = along.norm();
  std::vector<Rect> holes;
  for (const Opening& opening : wall.openings) {
    const double half = 0.5 * opening.width_m + kJamb_m;
    holes.push_back({{opening.at_m - half, -0.05}, {opening.at_m + half, opening.height_m + kJamb_m}});
    AddFrame(scene, T, opening);
  }
  for (const Rect& r : CoverAround({{0.0, -0.05}, {length, storey.ceiling_m + 0.05}}, holes)) {
    const bool low = r.min.y() < kReachHeight_m;
    WallBox(scene, kInnerWalls, T, Vec3(r.min.x(), -0.5 * kPartition_m, r.min.y()),
            Vec3(r.max.x(), 0.5 * kPartition_m, r.max.y()), low ? Physics::kSolid : Physics::kNone);
  }
}

void AddTable(SceneBuilder& scene, const Storey& storey, const Vec2& at, double length, double width,
              double yaw_rad) {
  const Paint paint{"tables", Label::kFurniture, true};
  const core::Pose T = core::PoseFromXyzYaw(Vec3(at.x(), at.y(), storey.floor_z), yaw_rad);
  const double x = 0.5 * length, y = 0.5 * width;
  WallBox(scene, paint, T, Vec3(-x, -y, 0.71), Vec3(x, y, 0.75), Physics::kSolid);
  for (double sx : {-1.0, 1.0}) {
    for (double sy : {-1.0, 1.0}) {
      const Vec3 p(sx * (x - 0.06), sy * (y - 0.06), 0.0);
      WallBox(scene, paint, T, p - Vec3(0.035, 0.035, 0.02), p + Vec3(0.035, 0.035, 0.72), Physics::kSolid);
    }
  }
}

void AddCabinet(SceneBuilder& scene, const Storey& storey, const Vec2& at, const Vec3& size, double yaw_rad) {
  const Paint paint{"cabinets", Label::kFurniture, true};
  const core::Pose T = core::PoseFromXyzYaw(Vec3(at.x(), at.y(), storey.floor_z), yaw_rad);
  const Vec3 half = 0.5 * size;
  WallBox(scene, paint, T, Vec3(-half.x(), -half.y(), -0.02), Vec3(half.x(), half.y(), size.z()),
          Physics::kSolid);
  const int doors = std::max(1, static_cast<int>(size.x() / 0.5));
  for (int k = 0; k < doors; ++k) {
    const double x0 = -half.x() + k * size.x() / doors, x1 = x0 + size.x() / doors;
    WallBox(scene, paint, T, Vec3(x0 + 0.02, -half.y() - 0.02, 0.1),
            Vec3(x1 - 0.02, -half.y(), size.z() - 0.04));
  }
}

void AddSofa(SceneBuilder& scene, const Storey& storey, const Vec2& at, double yaw_rad) {
  const Paint paint{"sofas", Label::kFurniture, true};
  const core::Pose T = core::PoseFromXyzYaw(Vec3(at.x(), at.y(), storey.floor_z), yaw_rad);
  WallBox(scene, paint, T, Vec3(-0.95, -0.42, -0.02), Vec3(0.95, 0.42, 0.42), Physics::kSolid);
  WallBox(scene, paint, T, Vec3(-0.95, 0.2, 0.4), Vec3(0.95, 0.42, 0.85));
  for (double x : {-0.95, 0.77}) WallBox(scene, paint, T, Vec3(x, -0.42, 0.4), Vec3(x + 0.18, 0.22, 0.62));
  for (double x : {-0.76, 0.01}) WallBox(scene, paint, T, Vec3(x, -0.44, 0.4), Vec3(x + 0.75, 0.2, 0.52));
}

void AddShelf(SceneBuilder& scene, const Storey& storey, const Vec2& at, double length, double yaw_rad,
              uint64_t seed) {
  const Paint paint{"shelves", Label::kFurniture, true}, boxes{"boxes", Label::kObject, true};
  const core::Pose T = core::PoseFromXyzYaw(Vec3(at.x(), at.y(), storey.floor_z), yaw_rad);
  const double x = 0.5 * length, y = 0.22;
  WallBox(scene, paint, T, Vec3(-x, -y, -0.02), Vec3(x, y, 0.12));
  scene.Collide(paint, {BoxShape{Vec3(x, y, 0.6)}, T * At(Vec3(0, 0, 0.6))});
  for (double z : {0.5, 0.9, 1.35, 1.8}) WallBox(scene, paint, T, Vec3(-x, -y, z), Vec3(x, y, z + 0.03));
  for (double sx : {-1.0, 0.0, 1.0}) {
    for (double sy : {-1.0, 1.0}) {
      const Vec3 p(sx * (x - 0.02), sy * (y - 0.02), 0.0);
      WallBox(scene, paint, T, p - Vec3(0.02, 0.02, 0.0), p + Vec3(0.02, 0.02, 1.9));
    }
  }
  core::Rng rng(seed);
  for (double z : {0.12, 0.53, 0.93, 1.38}) {
    for (double u = -x + 0.1; u + 0.45 < x; u += rng.Uniform(0.45, 0.9)) {
      const double width = rng.Uniform(0.2, 0.4), height = rng.Uniform(0.12, 0.3);
      WallBox(scene, boxes, T, Vec3(u, -0.17, z - 0.01), Vec3(u + width, 0.16, z + height));
    }
  }
}

}  // namespace atlas::scenes
