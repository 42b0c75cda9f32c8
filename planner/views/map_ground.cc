#include "planner/views/map_ground.h"

#include <cmath>
#include <utility>

namespace atlas::planner {
namespace {

using core::Vec2;
using core::Vec3;
using mapping::CellState;

constexpr double kProbeDownM = 1.5, kProbeUpM = 0.4;
constexpr double kLongestStepM = 1.2;

}  // namespace

MapGround::MapGround(const mapping::MapView& map, const BodyOnMap& body)
    : map_(map), body_(body), cell_m_(map.resolution_m()) {
  const int reach = static_cast<int>(std::ceil(body.radius_m / cell_m_));
  for (int i = -reach; i <= reach; ++i) {
    for (int j = -reach; j <= reach; ++j) {
      const Vec2 p(i * cell_m_, j * cell_m_);
      if (p.norm() <= body.radius_m) disc_.push_back(p);
    }
  }
}

/// Heights in steps of the climb: ground of one storey found from above or below is the same.
MapGround::Cell MapGround::CellOf(const Vec3& p) const {
  return {static_cast<int64_t>(std::floor(p.x() / cell_m_)),
          static_cast<int64_t>(std::floor(p.y() / cell_m_)),
          static_cast<int64_t>(std::floor(p.z() / body_.climb_m))};
}

bool MapGround::IsClear(const Vec2& p_map, double ground_m) const {
  int free = 0, all = 0;
  for (double h = body_.from_m; h <= body_.to_m; h += cell_m_, ++all) {
    const CellState state = map_.StateAt({p_map.x(), p_map.y(), ground_m + h});
    if (state == CellState::kOccupied) return false;
    free += state == CellState::kFree;
  }
  return free >= body_.free_share * all;
}

std::optional<double> MapGround::ColumnAt(const Vec3& p_map) const {
  const Cell cell = CellOf(p_map);
  const auto [known, fresh] = columns_.try_emplace(cell, std::nullopt);
  if (!fresh) return known->second;
  const Vec2 at = cell_m_ * Vec2(static_cast<double>(cell.x) + 0.5, static_cast<double>(cell.y) + 0.5);
  const double about = (static_cast<double>(cell.z) + 0.5) * body_.climb_m;
  // Through the middles of voxels, so that ground is as high whatever it is looked for from.
  const double from = (std::floor((about + kProbeUpM) / cell_m_) + 0.5) * cell_m_;
  bool open_below = false;
  std::optional<double> ground;
  for (double z = from; z > from - kProbeUpM - kProbeDownM && !ground; z -= cell_m_) {
    const CellState state = map_.StateAt({at.x(), at.y(), z});
    if (state == CellState::kOccupied) ground = z + 0.5 * cell_m_;  // its top
    open_below = open_below || (state == CellState::kFree && z < about - body_.climb_m);
  }
  if (!ground && !open_below) ground = about;
  if (ground && IsClear(at, *ground)) known->second = ground;
  return known->second;
}

bool MapGround::CanStand(const Vec3& p_map) const {
  const auto [known, fresh] = stands_.try_emplace(CellOf(p_map), false);
  if (!fresh) return known->second;
  const auto here = ColumnAt(p_map);
  if (!here) return false;
  for (const Vec2& d : disc_) {
    const auto ground = ColumnAt({p_map.x() + d.x(), p_map.y() + d.y(), *here});
    if (!ground || std::abs(*ground - *here) > body_.climb_m) return false;
  }
  known->second = true;
  return true;
}

std::optional<Vec3> MapGround::Step(const Vec3& from_map, const Vec2& to_map) const {
  const Vec2 way = to_map - from_map.head<2>();
  const int pieces = std::max(1, static_cast<int>(std::ceil(way.norm() / cell_m_)));
  Vec3 at = from_map;
  for (int k = 1; k <= pieces; ++k) {
    const Vec2 p = from_map.head<2>() + way * (static_cast<double>(k) / pieces);
    const auto ground = ColumnAt({p.x(), p.y(), at.z()});
    if (!ground || std::abs(*ground - at.z()) > body_.climb_m) return std::nullopt;
    at = {p.x(), p.y(), *ground};
    if (!CanStand(at)) return std::nullopt;
  }
  return at;
}

std::optional<MapWay> PlanOnMap(const MapGround& ground, const core::Box3& box_map, const Vec3& start,
                                const Vec3& goal, int iterations, core::Rng rng) {
  const auto under_start = ground.ColumnAt(start), under_goal = ground.ColumnAt(goal);
  if (!under_start || !under_goal || !ground.CanStand(start) || !ground.CanStand(goal)) return std::nullopt;
  GroundProblem problem;
  problem.start = {start.x(), start.y(), *under_start};
  problem.min = box_map.min.head<2>();
  problem.max = box_map.max.head<2>();
  problem.step_m = kLongestStepM;
  problem.can_stand = [&](const Vec2& p) {
    for (double z = box_map.min.z(); z < box_map.max.z(); z += 1.0) {
      if (ground.CanStand({p.x(), p.y(), z + 0.5})) return true;
    }
    return false;
  };
  problem.step = [&](const Vec3& from, const Vec2& to) { return ground.Step(from, to); };
  problem.effort = [](const Vec3& a, const Vec3& b) { return (b - a).norm(); };
  const Vec3 end(goal.x(), goal.y(), *under_goal);
  const auto points = PlanRrtStar(problem, end, iterations, std::move(rng));
  if (!points) return std::nullopt;
  MapWay way{*points, 0.0};
  for (size_t i = 1; i < points->size(); ++i) way.length_m += ((*points)[i] - (*points)[i - 1]).norm();
  return way;
}

}  // namespace atlas::planner
