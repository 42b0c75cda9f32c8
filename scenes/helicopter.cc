// A 3 x 8 m mock-up helicopter on a raised steel deck (thesis Fig. 3.1).
//
// Nose along +x, skids on the deck at z = 0. The deck's edges, its stairwells and the skirt under the belly
// are the mobility hazards of the thesis's site.
#include "scenes/build/convex_hull.h"
#include "scenes/build/deck.h"
#include "scenes/build/scene_builder.h"
#include "scenes/scenes.h"

namespace atlas::scenes {
namespace {

using core::Label;
using core::Radians;
using core::Vec2;
using core::Vec3;

/// A cross-section of the fuselage at x: half width, bottom and top.
struct Station {
  double x, half_width, bottom, top;
};

constexpr Station kFuselage[] = {
    {-0.90, 0.26, 1.30, 1.84}, {-0.30, 0.62, 0.86, 2.05}, {0.30, 0.86, 0.56, 2.13},
    {1.20, 0.95, 0.46, 2.16},  {2.20, 0.93, 0.45, 2.12},  {2.90, 0.83, 0.48, 1.96},
    {3.40, 0.65, 0.56, 1.60},  {3.80, 0.40, 0.70, 1.24},  {4.00, 0.13, 0.86, 1.04},
};
constexpr double kRingSpacing_m = 0.1;
constexpr int kCorners = 40;  ///< corner j at angle 2 pi j / kCorners from +y towards +z

/// Smooth interpolation (Catmull-Rom) of one column of the stations.
double StationValue(double x, double Station::*column) {
  constexpr int last = static_cast<int>(std::size(kFuselage)) - 1;
  int k = 0;
  while (k < last - 1 && x > kFuselage[k + 1].x) ++k;
  const auto at = [&](int i) { return kFuselage[std::clamp(i, 0, last)]; };
  const double span = at(k + 1).x - at(k).x, u = (x - at(k).x) / span;
  const auto slope = [&](int i) {
    return (at(i + 1).*column - at(i - 1).*column) / (at(i + 1).x - at(i - 1).x) * span;
  };
  const double p0 = at(k).*column, p1 = at(k + 1).*column;
  const double u2 = u * u, u3 = u2 * u;
  return (2 * u3 - 3 * u2 + 1) * p0 + (u3 - 2 * u2 + u) * slope(k) + (3 * u2 - 2 * u3) * p1 +
         (u3 - u2) * slope(k + 1);
}

/// A rounded rectangle (superellipse) in the plane x.
Ring Section(double x, double half_width, double bottom, double top, double exponent, int corners) {
  const auto rounded = [&](double c) { return std::copysign(std::pow(std::abs(c), 2.0 / exponent), c); };
  Ring ring;
  for (int j = 0; j < corners; ++j) {
    const double a = 2.0 * core::kPi * j / corners;
    ring.emplace_back(x, half_width * rounded(std::cos(a)),
                      0.5 * (bottom + top) + 0.5 * (top - bottom) * rounded(std::sin(a)));
  }
  return ring;
}

Ring FuselageRing(double x, int corners) {
  return Section(x, StationValue(x, &Station::half_width), StationValue(x, &Station::bottom),
                 StationValue(x, &Station::top), 2.7, corners);
}

void AddCabin(SceneBuilder& scene) {
  const double x_tail = kFuselage[0].x, x_nose = std::end(kFuselage)[-1].x;
  std::vector<Ring> rings;
  for (int i = 0; x_tail + i * kRingSpacing_m < x_nose + 1e-9; ++i) {
    rings.push_back(FuselageRing(x_tail + i * kRingSpacing_m, kCorners));
  }
  scene.Visual(Object("cabin", Label::kHelicopter), MakeLoft(rings));
  // Four convex stretches are what the robot can bump into.
  for (const auto& [from, to] : {std::pair{-0.5, 0.3}, {0.3, 1.6}, {1.6, 2.9}, {2.9, 4.0}}) {
    std::vector<core::Vec3f> points;
    for (double x : {from, 0.5 * (from + to), to}) {
      for (const Vec3& p : FuselageRing(x, 16)) points.push_back(p.cast<float>());
    }
    scene.Collide(Object("cabin", Label::kHelicopter),
                  {HullShape{ConvexHull(points)}, core::Pose::Identity()});
  }

  // A plate over x in [x0, x1] and corners [j0, j1]; the other side is its mirror image.
  const auto plate = [&](const Paint& paint, double x0, double x1, int j0, int j1, double proud) {
    const auto ring = [&](double x) { return static_cast<int>(std::lround((x - x_tail) / kRingSpacing_m)); };
    scene.Visual(paint, MakeLoftPatch(rings, ring(x0), ring(x1), j0, j1, proud, 0.02));
    const int half = kCorners / 2;
    scene.Visual(paint, MakeLoftPatch(rings, ring(x0), ring(x1), half - j1, half - j0, proud, 0.02));
  };
  const Paint window = Object("windows", Label::kWindow), door = Object("doors", Label::kDoor);
  plate(window, 2.9, 3.7, 3, 9, 0.010);
  plate(window, 3.3, 3.8, -6, -3, 0.010);
  plate(door, 1.7, 2.7, -6, 2, 0.012);
  plate(window, 1.7, 2.6, 3, 6, 0.010);
  plate(door, 0.4, 1.5, -6, 2, 0.012);
  plate(window, 0.5, 1.4, 3, 6, 0.010);
}

void AddTail(SceneBuilder& scene) {
  const Paint boom = Object("tail_boom", Label::kHelicopter), fin = Object("fin", Label::kHelicopter);
  std::vector<Ring> rings;
  for (int i = 0; i <= 12; ++i) {
    const double u = i / 12.0, x = -0.75 - 3.1 * u, radius = 0.27 - 0.14 * u, z = 1.58 + 0.2 * u;
    rings.push_back(Section(x, radius, z - radius, z + radius, 2.2, 24));
  }
  scene.Visual(boom, MakeLoft(rings));
  const std::vector<Vec2> outline = {{-4.0, 1.3}, {-3.82, 1.3}, {-3.3, 1.82}, {-3.72, 2.65}, {-4.0, 2.65}};
  scene.Visual(fin, MakeExtrusion(outline, -0.04, 0.04, SideOutline()));

  const Paint stabiliser = Object("stabiliser", Label::kHelicopter);
  scene.Box(stabiliser, Vec3(-2.85, -1.2, 1.69), Vec3(-2.45, 1.2, 1.74));
  for (double side : {-1.0, 1.0}) {
    const std::vector<Vec2> plate = {{-2.95, 1.5}, {-2.55, 1.5}, {-2.4, 1.75}, {-2.55, 2.1}, {-2.9, 2.1}};
    scene.Visual(stabiliser, MakeExtrusion(plate, side * 1.2 - 0.02, side * 1.2 + 0.02, SideOutline()));
  }

  const Paint rotor = Object("tail_rotor", Label::kRotor);
  const Vec3 hub(-3.84, 0.16, 2.25);
  scene.Cylinder(rotor, Vec3(hub.x(), 0.02, hub.z()), Vec3(hub.x(), 0.24, hub.z()), 0.07);
  const core::Pose T_map_blades =
      core::MakePose(core::RotationFromYawPitchRoll(0, Radians(25), 0), hub + Vec3(0, 0.04, 0));
  scene.Box(rotor, Vec3(0.06, 0.012, 0.58), T_map_blades);
}

void AddRotor(SceneBuilder& scene) {
  const Paint mast = Object("mast", Label::kRotor), blades = Object("blades", Label::kRotor);
  const Paint cowling = Object("cowling", Label::kHelicopter), exhaust = Object("exhaust", Label::kPipe);
  std::vector<Ring> rings;
  const Station stations[] = {{-0.75, 0.20, 1.75, 1.95}, {-0.45, 0.36, 1.75, 2.2}, {0.1, 0.46, 1.8, 2.42},
                              {0.9, 0.48, 1.8, 2.48},    {1.5, 0.42, 1.8, 2.38},   {1.9, 0.22, 1.9, 2.18}};
  for (const Station& s : stations) rings.push_back(Section(s.x, s.half_width, s.bottom, s.top, 3.0, 28));
  scene.Visual(cowling, MakeLoft(rings));
  for (double side : {-1.0, 1.0}) {
    scene.Tube(exhaust,
               {Vec3(0.0, 0.3 * side, 2.2), Vec3(-0.4, 0.45 * side, 2.28), Vec3(-0.75, 0.6 * side, 2.3)},
               0.09);
  }
  scene.Cylinder(mast, Vec3(0.9, 0, 2.3), Vec3(0.9, 0, 2.95), 0.08);
  scene.Cylinder(mast, Vec3(0.9, 0, 2.78), Vec3(0.9, 0, 2.9), 0.2);
  // Two blades, parked fore and aft.
  for (double yaw_deg : {7.0, 187.0}) {
    const core::Mat3 R = core::RotationFromYawPitchRoll(Radians(yaw_deg), Radians(1.5), 0.0);
    scene.Box(blades, Vec3(1.55, 0.12, 0.02), core::MakePose(R, Vec3(0.9, 0, 2.84) + R * Vec3(1.7, 0, 0)));
  }
}

void AddUndercarriage(SceneBuilder& scene) {
  const Paint skids = Object("skids", Label::kHelicopter), cross = Object("cross_tubes", Label::kHelicopter);
  for (double y : {-1.25, 1.25}) {
    scene.Tube(skids, {Vec3(-0.6, y, 0.06), Vec3(2.9, y, 0.06), Vec3(3.25, y, 0.15), Vec3(3.5, y, 0.36)},
               0.06);
  }
  for (double x : {0.45, 2.45}) {
    scene.Tube(cross,
               {Vec3(x, -1.25, 0.08), Vec3(x, -1.02, 0.36), Vec3(x, -0.5, 0.56), Vec3(x, 0.5, 0.56),
                Vec3(x, 1.02, 0.36), Vec3(x, 1.25, 0.08)},
               0.045);
  }
  scene.Box(Object("skirt", Label::kSkirt), Vec3(0.2, -0.62, 0.0), Vec3(3.1, 0.62, 0.5));
}

SceneSpec Build(const Paint& floor) {
  SceneBuilder scene;
  AddDeck(scene, floor);
  AddCabin(scene);
  AddTail(scene);
  AddRotor(scene);
  AddUndercarriage(scene);
  return scene.Finish(Vec2(1.2, -4.2), 0.0);
}

}  // namespace

SceneSpec BuildHelicopter() {
  return Build({"deck", Label::kDeck});
}

SceneSpec BuildHelicopterGrating() {
  constexpr double kOpenShare = 0.5;  ///< of the beams that meet a floor of bars
  return Build({"deck", Label::kGrating, false, kOpenShare});
}

}  // namespace atlas::scenes
