#include "scenes/build/deck.h"

#include "scenes/build/openings.h"

namespace atlas::scenes {
namespace {

using core::Label;
using core::Vec2;
using core::Vec3;

constexpr double kThickness_m = 0.25;
constexpr double kGroundBelow_m = -3.0;
const Rect kOutline{{-8.0, -7.0}, {8.0, 7.0}};
const Rect kStairwells[] = {{{4.6, 4.9}, {7.1, 5.9}}, {{-7.1, -5.9}, {-4.6, -4.9}}};

/// Posts at most 2 m apart from `a` to `b` (on the deck) and two rails.
void AddRailing(SceneBuilder& scene, const Vec2& a, const Vec2& b) {
  constexpr double kPostHeight_m = 1.1, kPostRadius_m = 0.03, kRailRadius_m = 0.025;
  const Paint post{"stanchions", Label::kStanchion}, rail{"rails", Label::kRail};
  const int gaps = static_cast<int>(std::ceil((b - a).norm() / 2.0));
  for (int k = 0; k <= gaps; ++k) {
    const Vec2 p = a + (b - a) * k / gaps;
    scene.Cylinder(post, Vec3(p.x(), p.y(), 0.0), Vec3(p.x(), p.y(), kPostHeight_m), kPostRadius_m, 12);
  }
  for (double z : {0.55, 1.06}) {
    scene.Cylinder(rail, Vec3(a.x(), a.y(), z), Vec3(b.x(), b.y(), z), kRailRadius_m, 12);
  }
}

/// A steep flight from the ground up along +x or -x to the deck, as wide as its well.
void AddStairs(SceneBuilder& scene, const Rect& well, bool rises_along_x) {
  constexpr int kSteps = 12;
  const Paint stairs{"stairs", Label::kStairs};
  const double tread = (well.max.x() - well.min.x()) / kSteps, rise = -kGroundBelow_m / (kSteps + 1);
  for (int k = 0; k < kSteps; ++k) {
    const double x0 = rises_along_x ? well.min.x() + k * tread : well.max.x() - (k + 1) * tread;
    scene.Box(stairs, Vec3(x0, well.min.y() + 0.05, kGroundBelow_m),
              Vec3(x0 + tread, well.max.y() - 0.05, kGroundBelow_m + (k + 1) * rise), Physics::kNone);
  }
  const double x_foot = rises_along_x ? well.min.x() : well.max.x(),
               x_head = rises_along_x ? well.max.x() : well.min.x();
  std::vector<Vec2> slope = {{x_foot, kGroundBelow_m}, {x_head, kGroundBelow_m}, {x_head, -rise}};
  if (!rises_along_x) std::swap(slope[0], slope[1]);
  // One ramp stands for the flight: nothing should ever touch it but a robot that fell.
  scene.Collide(stairs,
                {HullShape{MakeExtrusion(slope, -well.max.y() + 0.05, -well.min.y() - 0.05, SideOutline())},
                 core::Pose::Identity()});
}

}  // namespace

void AddDeck(SceneBuilder& scene, const Paint& floor) {
  scene.Box({"ground", Label::kGround}, Vec3(-40, -40, kGroundBelow_m - 0.5), Vec3(40, 40, kGroundBelow_m));
  for (const Rect& plate : CoverAround(kOutline, {kStairwells[0], kStairwells[1]})) {
    scene.Box(floor, Vec3(plate.min.x(), plate.min.y(), -kThickness_m),
              Vec3(plate.max.x(), plate.max.y(), 0.0));
  }
  for (double x : {-7.2, 0.0, 7.2}) {
    for (double y : {-6.4, 6.4}) {
      scene.Box({"deck_legs", Label::kColumn}, Vec3(x - 0.15, y - 0.15, kGroundBelow_m),
                Vec3(x + 0.15, y + 0.15, -kThickness_m), Physics::kNone);
    }
  }
  AddStairs(scene, kStairwells[0], false);
  AddStairs(scene, kStairwells[1], true);

  constexpr double kInset_m = 0.06;
  const double x0 = kOutline.min.x() + kInset_m, x1 = kOutline.max.x() - kInset_m;
  const double y0 = kOutline.min.y() + kInset_m, y1 = kOutline.max.y() - kInset_m;
  AddRailing(scene, {x0, y1}, {x1, y1});
  AddRailing(scene, {x0, y0}, {x0, y1 - 0.3});
  AddRailing(scene, {x0 + 0.3, y0}, {-0.4, y0});
  // One side of each stairwell has a rail; the others drop without warning.
  AddRailing(scene, {4.6, 4.84}, {7.1, 4.84});
  AddRailing(scene, {-7.1, -4.84}, {-4.6, -4.84});
}

}  // namespace atlas::scenes
