#include "sim/locomotion/foothold.h"

#include <array>

#include "sim/locomotion/gait_schedule.h"
#include "sim/world/robot_state.h"

namespace atlas::sim {
namespace {

using core::Vec2;

constexpr double kMaxReachM = 0.26;
constexpr double kComShare = 0.5;
constexpr double kUnsteppableCost = 100.0;
constexpr double kUnknownCost = 60.0;
constexpr double kMoveCostPerM = 4.0;
constexpr double kRiserCost = 0.25;
constexpr double kRiserM = 0.05;

struct Window {
  int half_along, half_across;
  double step_along_m, step_across_m;
};
constexpr Window kNear = {6, 1, 0.025, 0.03};
constexpr Window kWide = {7, 4, 0.03, 0.03};

/// Unit directions of the ring samples, eight a ring.
const std::array<Vec2, 8>& Compass() {
  static const std::array<Vec2, 8> directions = [] {
    std::array<Vec2, 8> d;
    for (size_t i = 0; i < 8; ++i) d[i] = Vec2(std::cos(core::kPi / 4 * i), std::sin(core::kPi / 4 * i));
    return d;
  }();
  return directions;
}

double EdgeCost(const TerrainSampler& terrain, const Vec2& p, double z) {
  constexpr std::array<std::pair<double, double>, 2> kRings = {{{0.035, 1.0}, {0.06, 0.4}}};
  constexpr double kToleranceM = 0.03, kToleranceSlope = 0.4;
  double cost = 0.0;
  for (const auto& [radius, weight] : kRings) {
    for (const Vec2& direction : Compass()) {
      const Vec2 q = p + radius * direction;
      const TerrainSampler::Sample ground = terrain.At(q.x(), q.y());
      if (ground.known && std::abs(ground.z - z) > kToleranceM + kToleranceSlope * radius) cost += weight;
    }
  }
  return cost;
}

double RiserCost(const TerrainSampler& terrain, const Vec2& p, double z, const Vec2& knee_direction) {
  double cost = 0.0;
  for (const double distance : {0.06, 0.09, 0.12, 0.15}) {
    const Vec2 q = p + distance * knee_direction;
    const TerrainSampler::Sample ground = terrain.At(q.x(), q.y());
    if (ground.known && ground.z - z > kRiserM) cost += kRiserCost;
  }
  return cost;
}

struct Candidate {
  Foothold foothold;
  double cost = 1e9;
};

Candidate Judge(const TerrainSampler& terrain, const Vec2& nominal, const Vec2& offset,
                const Vec2& knee_direction, double cost_to_beat) {
  Candidate c;
  const Vec2 p = nominal + offset;
  const TerrainSampler::Sample ground = terrain.At(p.x(), p.y());
  c.foothold = {offset, ground.z, ground.steppable};
  c.cost = kMoveCostPerM * offset.norm();
  if (!ground.steppable) c.cost += ground.known ? kUnsteppableCost : kUnknownCost;
  if (c.cost >= cost_to_beat) return c;
  c.cost += EdgeCost(terrain, p, ground.z) + RiserCost(terrain, p, ground.z, knee_direction);
  return c;
}

Candidate Best(const TerrainSampler& terrain, const Vec2& nominal, const Vec2& ahead,
               const Vec2& knee_direction, const Window& window, Candidate best) {
  const Vec2 left(-ahead.y(), ahead.x());
  for (int a = -window.half_along; a <= window.half_along; ++a) {
    for (int b = -window.half_across; b <= window.half_across; ++b) {
      const Vec2 offset = a * window.step_along_m * ahead + b * window.step_across_m * left;
      const Candidate c = Judge(terrain, nominal, offset, knee_direction, best.cost);
      if (c.cost < best.cost) best = c;
    }
  }
  return best;
}

}  // namespace

Vec2 NominalFoothold(const FootholdInput& in) {
  const double yaw_at_mid_stance =
      in.yaw_rad + in.yaw_rate_command * (in.swing_left_s + 0.5 * GaitSchedule::kStanceS);
  const Vec2 under_hip =
      in.p_base + in.v_base * in.swing_left_s + Eigen::Rotation2Dd(yaw_at_mid_stance) * in.nominal_base;
  const double capture_s = 0.5 * std::sqrt(std::max(0.3, in.height_m) / kGravity);
  Vec2 reach = kComShare * in.com_offset + 0.5 * GaitSchedule::kStanceS * in.v_command +
               capture_s * (in.v_base - in.v_command);
  if (reach.norm() > kMaxReachM) reach *= kMaxReachM / reach.norm();
  return under_hip + reach;
}

Foothold SearchFoothold(const TerrainSampler& terrain, const Vec2& nominal, double yaw_rad,
                        double knee_sign) {
  const Vec2 ahead(std::cos(yaw_rad), std::sin(yaw_rad));
  const Vec2 knee_direction = knee_sign * ahead;
  Candidate best = Judge(terrain, nominal, Vec2::Zero(), knee_direction, 1e9);
  if (best.cost <= 0.0) return best.foothold;
  best = Best(terrain, nominal, ahead, knee_direction, kNear, best);
  if (!best.foothold.steppable) best = Best(terrain, nominal, ahead, knee_direction, kWide, best);
  return best.foothold;
}

}  // namespace atlas::sim
