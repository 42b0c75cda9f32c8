// A saloon car, 4.5 x 1.8 x 1.5 m, nose along +x, standing on flat ground.
#include "scenes/build/ground.h"
#include "scenes/scenes.h"

namespace atlas::scenes {
namespace {

using core::Label;
using core::Radians;
using core::Vec2;
using core::Vec3;

constexpr double kAxle_m = 1.36, kWheelRadius_m = 0.32, kArchRadius_m = 0.385, kSill_m = 0.22;

/// The side view (x, z) below the windows, wheel arches cut out.
std::vector<Vec2> BodyOutline() {
  std::vector<Vec2> outline = {{-2.22, 0.36}, {-2.1, 0.26}};
  for (double axle : {-kAxle_m, kAxle_m}) {
    constexpr int kSteps = 10;
    const double dip = std::asin((kSill_m - kWheelRadius_m) / kArchRadius_m);
    for (int k = 0; k <= kSteps; ++k) {
      const double a = core::kPi - dip + (2 * dip - core::kPi) * k / kSteps;
      outline.emplace_back(axle + kArchRadius_m * std::cos(a), kWheelRadius_m + kArchRadius_m * std::sin(a));
    }
  }
  const std::vector<Vec2> top = {{2.1, 0.24},  {2.22, 0.34},  {2.25, 0.5},   {2.22, 0.62},
                                 {2.1, 0.72},  {1.8, 0.80},   {1.4, 0.86},   {1.0, 0.91},
                                 {0.3, 0.93},  {-0.6, 0.94},  {-1.4, 0.96},  {-1.8, 0.97},
                                 {-2.1, 0.95}, {-2.21, 0.86}, {-2.24, 0.62}, {-2.25, 0.45}};
  outline.insert(outline.end(), top.begin(), top.end());
  return outline;
}

/// The outline drawn in at the flanks: shorter by `ends_m` and lower by `top_m` where it is high.
std::vector<Vec2> DrawnIn(std::vector<Vec2> outline, double ends_m, double top_m) {
  for (Vec2& p : outline) {
    const double toward_end = std::pow(std::abs(p.x()) / 2.25, 4.0);
    p.x() -= std::copysign(ends_m * toward_end, p.x());
    p.y() -= top_m * std::clamp((p.y() - 0.55) / 0.35, 0.0, 1.0);
  }
  return outline;
}

void AddBody(SceneBuilder& scene) {
  const std::vector<Vec2> outline = BodyOutline();
  const auto flank = DrawnIn(outline, 0.16, 0.12), shoulder = DrawnIn(outline, 0.07, 0.03);
  scene.Convex(Object("body", Label::kVehicle),
               MakeProfileLoft({flank, shoulder, outline, outline, shoulder, flank},
                               {-0.88, -0.82, -0.62, 0.62, 0.82, 0.88}, SideOutline()));
  // The floor pan closes the wheel wells on the inside, up over their arches: no slit from side to side.
  scene.Visual(Object("underside", Label::kVehicle), MakeBox(Vec3(2.0, 0.6, 0.255), At(Vec3(0, 0, 0.495))));
}

/// Four corners at height z: the greenhouse seen from above.
Ring Level(double z, double x_rear, double x_front, double half_width) {
  return {Vec3(x_rear, -half_width, z), Vec3(x_front, -half_width, z), Vec3(x_front, half_width, z),
          Vec3(x_rear, half_width, z)};
}

/// A pane on the side k of the greenhouse (k from corner k to k + 1), between shares of its width and height.
Ring Pane(const Ring& low, const Ring& high, int k, double u0, double u1, double v0, double v1) {
  const auto at = [&](double u, double v) -> Vec3 {
    const Vec3 a = low[k] + u * (low[(k + 1) % 4] - low[k]), b = high[k] + u * (high[(k + 1) % 4] - high[k]);
    return a + v * (b - a);
  };
  return {at(u0, v0), at(u1, v0), at(u1, v1), at(u0, v1)};
}

void AddGreenhouse(SceneBuilder& scene) {
  const Ring low = Level(0.90, -1.85, 1.12, 0.80), high = Level(1.40, -1.22, 0.32, 0.60);
  scene.Convex(Object("roof", Label::kVehicle), MakeLoft({low, high, Level(1.47, -1.0, 0.1, 0.46)}));
  const Paint glass = Object("windows", Label::kWindow);
  constexpr double kProud_m = 0.006, kDepth_m = 0.02;
  for (int side : {0, 2}) {
    for (const auto& [u0, u1] : {std::pair{0.17, 0.50}, {0.53, 0.86}}) {
      const bool mirrored = side == 2;
      scene.Visual(
          glass, MakePanel(Pane(low, high, side, mirrored ? 1 - u1 : u0, mirrored ? 1 - u0 : u1, 0.14, 0.92),
                           kProud_m, kDepth_m));
    }
  }
  for (int end : {1, 3}) {
    scene.Visual(glass, MakePanel(Pane(low, high, end, 0.08, 0.92, 0.14, 0.94), kProud_m, kDepth_m));
  }
}

void AddWheels(SceneBuilder& scene) {
  for (double x : {-kAxle_m, kAxle_m}) {
    for (double side : {-1.0, 1.0}) {
      scene.Cylinder(Object("wheels", Label::kWheel), Vec3(x, 0.66 * side, kWheelRadius_m),
                     Vec3(x, 0.87 * side, kWheelRadius_m), kWheelRadius_m, 28);
      scene.Visual(
          Object("rims", Label::kVehicle),
          MakeFrustum(
              0.2, 0.17, 0.012,
              PoseBetween(Vec3(x, 0.865 * side, kWheelRadius_m), Vec3(x, 0.889 * side, kWheelRadius_m)), 20));
    }
  }
}

void AddFittings(SceneBuilder& scene) {
  const Paint trim = Object("trim", Label::kWheel), lamp = Object("lamps", Label::kWindow),
              body = Object("body", Label::kVehicle);
  scene.Box(trim, Vec3(2.1, -0.68, 0.3), Vec3(2.275, 0.68, 0.42), Physics::kNone);
  scene.Box(trim, Vec3(2.1, -0.36, 0.5), Vec3(2.255, 0.36, 0.6), Physics::kNone);
  scene.Box(trim, Vec3(-2.275, -0.68, 0.34), Vec3(-2.1, 0.68, 0.46), Physics::kNone);
  for (double side : {-1.0, 1.0}) {
    const auto box = [&](const Paint& paint, const Vec3& a, const Vec3& b) {
      scene.Box(paint, Vec3(a.x(), std::min(side * a.y(), side * b.y()), a.z()),
                Vec3(b.x(), std::max(side * a.y(), side * b.y()), b.z()), Physics::kNone);
    };
    box(lamp, Vec3(2.0, 0.42, 0.49), Vec3(2.25, 0.68, 0.61));
    box(lamp, Vec3(-2.235, 0.42, 0.64), Vec3(-2.0, 0.7, 0.8));
    box(trim, Vec3(-0.05, 0.84, 0.76), Vec3(0.13, 0.9, 0.79));
    box(trim, Vec3(-1.05, 0.84, 0.77), Vec3(-0.87, 0.9, 0.8));
    box(trim, Vec3(-0.95, 0.84, 0.24), Vec3(0.95, 0.895, 0.3));
    const core::Pose T_map_mirror = core::MakePose(
        core::RotationFromYawPitchRoll(Radians(-12.0 * side), 0, 0), Vec3(0.66, 0.93 * side, 1.0));
    scene.Box(body, Vec3(0.05, 0.11, 0.07), T_map_mirror);
  }
}

}  // namespace

SceneSpec BuildCar() {
  SceneBuilder scene;
  AddFlatGround(scene, {{-12.0, -11.0}, {12.0, 11.0}});
  AddBody(scene);
  AddGreenhouse(scene);
  AddWheels(scene);
  AddFittings(scene);
  return scene.Finish(Vec2(-0.4, -3.8), 0.0);
}

}  // namespace atlas::scenes
