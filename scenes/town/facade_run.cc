#include "scenes/town/facade_run.h"

#include <algorithm>

namespace atlas::scenes {
namespace {

using core::Label;
using core::Vec2;
using core::Vec3;

constexpr double kRecess_m = 0.22, kWindowWidth_m = 1.3, kWindowHeight_m = 1.9, kSill_m = 0.95;
constexpr double kDoorWidth_m = 1.3, kDoorHeight_m = 2.4;

/// The paints of one front.
struct Paints {
  Paint wall, glass, frame, ledge, door, column, roof;
  explicit Paints(const std::string& name)
      : wall{name + "_walls", Label::kWall, true},
        glass{name + "_windows", Label::kWindow, true},
        frame{name + "_frames", Label::kLedge, true},
        ledge{name + "_ledges", Label::kLedge, true},
        door{name + "_doors", Label::kDoor, true},
        column{name + "_pilasters", Label::kColumn, true},
        roof{name + "_roofs", Label::kRoof, true} {}
};

struct Front {
  SceneBuilder& scene;
  const FacadeRun& run;
  Paints paint;
  double bay_m;

  void Add(const Paint& p, double x0, double y0, double z0, double x1, double y1, double z1,
           Physics physics = Physics::kNone) const {
    WallBox(scene, p, run.T_map_wall, Vec3(x0, y0, z0), Vec3(x1, y1, z1), physics);
  }
  double Middle(int bay) const { return (bay + 0.5) * bay_m; }
  bool HasDoor(int bay) const {
    return std::find(run.door_bays.begin(), run.door_bays.end(), bay) != run.door_bays.end();
  }
  /// Whether the archway takes the place of what would be at x on the ground floor.
  bool InArchway(double x, double margin_m) const {
    return run.archway && x > run.archway->min.x() - margin_m && x < run.archway->max.x() + margin_m;
  }
};

void AddWindow(const Front& front, double x, double z0, double width, double height) {
  const double a = x - 0.5 * width, b = x + 0.5 * width, z1 = z0 + height;
  front.Add(front.paint.glass, a, kRecess_m, z0, b, kFrontDepth_m, z1);
  const double bar = kRecess_m - 0.05;
  front.Add(front.paint.frame, a, bar, z0, a + 0.07, kRecess_m, z1);
  front.Add(front.paint.frame, b - 0.07, bar, z0, b, kRecess_m, z1);
  front.Add(front.paint.frame, a, bar, z0 + 0.55 * height, b, kRecess_m, z0 + 0.55 * height + 0.06);
  if (front.run.ornate) {
    front.Add(front.paint.frame, x - 0.03, bar, z0, x + 0.03, kRecess_m, z1);
    front.Add(front.paint.ledge, a - 0.12, -0.06, z1, b + 0.12, 0.02, z1 + 0.2);
  }
  front.Add(front.paint.ledge, a - 0.1, -0.1, z0 - 0.12, b + 0.1, kRecess_m, z0);
}

void AddDoor(const Front& front, double x) {
  const double a = x - 0.5 * kDoorWidth_m, b = x + 0.5 * kDoorWidth_m;
  front.Add(front.paint.door, a, kRecess_m + 0.06, front.run.foot_m, b, kFrontDepth_m, kDoorHeight_m,
            Physics::kSolid);
  for (double dx : {-0.3, 0.3}) {
    for (double z : {0.35, 1.3}) {
      front.Add(front.paint.door, x + dx - 0.22, kRecess_m + 0.03, z, x + dx + 0.22, kRecess_m + 0.07,
                z + 0.75);
    }
  }
  for (double side : {a - 0.2, b}) {
    front.Add(front.paint.ledge, side, -0.08, front.run.foot_m, side + 0.2, 0.02, kDoorHeight_m);
  }
  front.Add(front.paint.ledge, a - 0.3, -0.14, kDoorHeight_m, b + 0.3, 0.02, kDoorHeight_m + 0.28);
  front.Add(front.paint.ledge, a - 0.15, -0.45, front.run.foot_m, b + 0.15, kRecess_m + 0.06, 0.12);
}

/// Wall with holes for the openings of all floors; what a robot can touch of it has physics.
void AddWall(const Front& front, const std::vector<Rect>& openings) {
  const FacadeRun& run = front.run;
  const Rect outline{{0.0, run.foot_m}, {run.length_m, run.height_m()}};
  for (const Rect& r : CoverAround(outline, openings)) {
    front.Add(front.paint.wall, r.min.x(), 0.0, r.min.y(), r.max.x(), kFrontDepth_m, r.max.y());
  }
  std::vector<Rect> gaps;
  constexpr double kTouch_m = kSill_m - 0.15;
  for (const Rect& r : openings) {
    if (r.min.y() < kTouch_m) gaps.push_back({r.min, {r.max.x(), kTouch_m}});
  }
  for (const Rect& r : CoverAround({{0.0, run.foot_m}, {run.length_m, kTouch_m}}, gaps)) {
    const Vec3 half(0.5 * (r.max.x() - r.min.x()), 0.5 * kFrontDepth_m, 0.5 * (r.max.y() - r.min.y()));
    const Vec3 middle(0.5 * (r.min.x() + r.max.x()), 0.5 * kFrontDepth_m, 0.5 * (r.min.y() + r.max.y()));
    front.scene.Collide(front.paint.wall, {BoxShape{half}, run.T_map_wall * At(middle)});
  }
}

/// What stands proud of an ornate wall.
void AddOrnament(const Front& front) {
  const FacadeRun& run = front.run;
  const double top = run.height_m();
  for (int k = 0; k <= run.bays(); ++k) {
    const double x = std::clamp(k * front.bay_m, 0.25, run.length_m - 0.25);
    if (front.InArchway(x, 0.3)) continue;
    front.Add(front.paint.column, x - 0.25, -0.16, run.foot_m, x + 0.25, 0.02, top - 0.3);
    front.Add(front.paint.column, x - 0.33, -0.24, run.foot_m, x + 0.33, 0.02, 0.6);
    front.Add(front.paint.column, x - 0.33, -0.24, top - 0.65, x + 0.33, 0.02, top - 0.3);
  }
  for (int floor = 1; floor < run.storeys; ++floor) {
    const double z = floor * run.storey_m + 0.1;
    front.Add(front.paint.ledge, 0.0, -0.1, z, run.length_m, 0.02, z + 0.22);
  }
  for (int k = 0; k < run.bays(); ++k) {
    for (double share : {0.25, 0.75}) {
      const double x = (k + share) * front.bay_m;
      front.Add(front.paint.wall, x - 0.45, 0.05, top, x + 0.45, 0.3, top + 0.7);
    }
  }
}

void AddPlinth(const Front& front, const std::vector<Rect>& openings) {
  constexpr double kTop_m = 0.5;
  std::vector<Rect> gaps;
  for (const Rect& r : openings) {
    const bool framed = !front.run.archway || r.min.x() != front.run.archway->min.x();
    const double margin = framed ? 0.2 : 0.0;
    if (r.min.y() < kTop_m) gaps.push_back({{r.min.x() - margin, r.min.y()}, {r.max.x() + margin, kTop_m}});
  }
  for (const Rect& r : CoverAround({{0.0, front.run.foot_m}, {front.run.length_m, kTop_m}}, gaps)) {
    front.Add(front.paint.ledge, r.min.x(), -0.05, r.min.y(), r.max.x(), 0.02, r.max.y());
  }
}

}  // namespace

int FacadeRun::bays() const {
  return std::max(1, static_cast<int>(std::lround(length_m / bay_m)));
}

void WallBox(SceneBuilder& scene, const Paint& paint, const core::Pose& T_map_wall, const Vec3& min,
             const Vec3& max, Physics physics) {
  const Vec3 half = 0.5 * (max - min);
  const core::Pose T_map_box = T_map_wall * At(0.5 * (min + max));
  if (physics == Physics::kSolid) {
    scene.Box(paint, half, T_map_box);
  } else {
    scene.Visual(paint, MakeBox(half, T_map_box));
  }
}

void AddFacadeRun(SceneBuilder& scene, const FacadeRun& run) {
  const Front front{scene, run, Paints(run.name), run.length_m / run.bays()};
  std::vector<Rect> openings;
  if (run.archway) openings.push_back(*run.archway);
  for (int floor = 0; floor < run.storeys; ++floor) {
    const double z0 = floor * run.storey_m + kSill_m,
                 height = std::min(kWindowHeight_m, run.storey_m - kSill_m - 0.5);
    for (int bay = 0; bay < run.bays(); ++bay) {
      const double x = front.Middle(bay);
      if (z0 < (run.archway ? run.archway->max.y() + 0.2 : 0.0) && front.InArchway(x, 0.9)) continue;
      if (floor == 0 && front.HasDoor(bay)) {
        openings.push_back({{x - 0.5 * kDoorWidth_m, run.foot_m}, {x + 0.5 * kDoorWidth_m, kDoorHeight_m}});
        AddDoor(front, x);
      } else {
        openings.push_back({{x - 0.5 * kWindowWidth_m, z0}, {x + 0.5 * kWindowWidth_m, z0 + height}});
        AddWindow(front, x, z0, kWindowWidth_m, height);
      }
    }
  }
  AddWall(front, openings);
  AddPlinth(front, openings);
  const double top = run.height_m();
  front.Add(front.paint.ledge, 0.0, -0.32, top - 0.3, run.length_m, 0.02, top);
  if (run.ornate) AddOrnament(front);
}

void AddVault(SceneBuilder& scene, const Paint& paint, const core::Pose& T_map_wall, double middle_x,
              double half_width_m, double spring_z, double top_z, double y0, double y1) {
  constexpr int kSteps = 20;
  std::vector<Vec2> outline;
  for (int k = 0; k <= kSteps; ++k) {
    const double a = core::kPi * (1.0 - static_cast<double>(k) / kSteps);
    outline.emplace_back(middle_x + half_width_m * std::cos(a), spring_z + half_width_m * std::sin(a));
  }
  outline.emplace_back(middle_x + half_width_m, top_z);
  outline.emplace_back(middle_x - half_width_m, top_z);
  scene.Visual(paint, MakeExtrusion(outline, -y1, -y0, T_map_wall * SideOutline()));
}

}  // namespace atlas::scenes
