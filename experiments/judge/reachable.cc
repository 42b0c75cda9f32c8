#include "experiments/judge/reachable.h"

#include <cmath>
#include <deque>

#include "experiments/judge/scene_surface.h"

namespace atlas::experiments {
namespace {

using core::Box3;
using core::Vec2;
using core::Vec3;

constexpr float kNoGround = std::numeric_limits<float>::quiet_NaN();

/// Heights that some triangle occupies in one column.
struct Span {
  uint32_t column;
  float lo, hi;
};

/// All spans, by column.
struct Columns {
  std::vector<Span> spans;
  std::vector<uint32_t> begin;  // a column each, one more at the end
};

using Triangle = std::array<Vec3, 3>;

Box3 ExtentOf(const std::vector<Vec3>& points) {
  Box3 extent;
  for (const Vec3& p : points) extent.Extend(p);
  return extent;
}

/// Cell `index` of the grid along `axis`, as far as the box reaches along the others.
Box3 Slice(Box3 box, int axis, int index, const ReachableSet& grid) {
  box.min[axis] = grid.origin[axis] + index * grid.cell_m;
  box.max[axis] = box.min[axis] + grid.cell_m;
  return box;
}

/// Calls visit(row, col, lo, hi) for each column that the triangle crosses inside the region.
template <typename Visit>
void CutToColumns(const Triangle& triangle, const ReachableSet& grid, const Box3& region,
                  const Visit& visit) {
  const std::vector<Vec3> inside = ClipTriangle(triangle, region);
  if (inside.empty()) return;
  const Box3 extent = ExtentOf(inside);
  const auto cell = [&](double v, double origin, int count) {
    return std::clamp(static_cast<int>(std::floor((v - origin) / grid.cell_m)), 0, count - 1);
  };
  const int row_lo = cell(extent.min.y(), grid.origin.y(), grid.rows),
            row_hi = cell(extent.max.y(), grid.origin.y(), grid.rows);
  for (int row = row_lo; row <= row_hi; ++row) {
    const Box3 strip = Slice(region, 1, row, grid);
    const std::vector<Vec3> in_row = ClipTriangle(triangle, strip);
    if (in_row.empty()) continue;
    const Box3 row_extent = ExtentOf(in_row);
    const bool flat = row_extent.Size().z() < 1e-6;
    const int col_lo = cell(row_extent.min.x(), grid.origin.x(), grid.cols),
              col_hi = cell(row_extent.max.x(), grid.origin.x(), grid.cols);
    for (int col = col_lo; col <= col_hi; ++col) {
      if (flat) {
        visit(row, col, row_extent.min.z(), row_extent.max.z());
        continue;
      }
      const std::vector<Vec3> piece = ClipTriangle(triangle, Slice(strip, 0, col, grid));
      if (piece.empty()) continue;
      const Box3 bounds = ExtentOf(piece);
      visit(row, col, bounds.min.z(), bounds.max.z());
    }
  }
}

Columns CutScene(const scenes::SceneSpec& scene, const ReachableSet& grid, const Box3& region) {
  std::vector<Span> unsorted;
  for (const scenes::ScenePart& part : scene.parts) {
    const auto vertex = [&](uint32_t i) { return part.mesh.vertices[i].cast<double>().eval(); };
    for (const auto& t : part.mesh.triangles) {
      CutToColumns({vertex(t[0]), vertex(t[1]), vertex(t[2])}, grid, region,
                   [&](int row, int col, double lo, double hi) {
                     unsorted.push_back({static_cast<uint32_t>(grid.IndexOf(row, col)),
                                         static_cast<float>(lo), static_cast<float>(hi)});
                   });
    }
  }
  Columns columns;
  columns.begin.assign(static_cast<size_t>(grid.rows) * grid.cols + 1, 0);
  for (const Span& span : unsorted) ++columns.begin[span.column + 1];
  for (size_t i = 1; i < columns.begin.size(); ++i) columns.begin[i] += columns.begin[i - 1];
  std::vector<uint32_t> next(columns.begin.begin(), columns.begin.end() - 1);
  columns.spans.resize(unsorted.size());
  for (const Span& span : unsorted) columns.spans[next[span.column]++] = span;
  return columns;
}

/// Ground of a column seen from ground at `from_m`: the highest surface within a step, NaN where there is
/// none or something stands between it and the robot's top.
float GroundOf(const Columns& columns, size_t column, float from_m, const robots::RobotSpec& robot) {
  const float step = static_cast<float>(robot.max_step_m) + 1e-3f;
  float ground = -std::numeric_limits<float>::infinity();
  for (uint32_t i = columns.begin[column]; i < columns.begin[column + 1]; ++i) {
    const Span& span = columns.spans[i];
    if (span.hi <= from_m + step) ground = std::max(ground, span.hi);
  }
  if (ground < from_m - step) return kNoGround;
  const float top = ground + static_cast<float>(robot.stance_height_m + robot.body_top_m);
  for (uint32_t i = columns.begin[column]; i < columns.begin[column + 1]; ++i) {
    const Span& span = columns.spans[i];
    if (span.hi > ground + 1e-4f && span.lo < top) return kNoGround;
  }
  return ground;
}

constexpr std::array<std::array<int, 2>, 4> kSteps = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

void FloodGround(const Columns& columns, const robots::RobotSpec& robot, const Vec3& spawn,
                 ReachableSet* set) {
  int row, col;
  if (!set->CellUnder(spawn.head<2>(), &row, &col)) return;
  const float start = GroundOf(columns, set->IndexOf(row, col), static_cast<float>(spawn.z()), robot);
  if (std::isnan(start)) return;
  set->ground_m[set->IndexOf(row, col)] = start;
  std::deque<std::array<int, 2>> front = {{row, col}};
  while (!front.empty()) {
    const auto [r, c] = front.front();
    front.pop_front();
    for (const auto& [dr, dc] : kSteps) {
      const int nr = r + dr, nc = c + dc;
      if (nr < 0 || nr >= set->rows || nc < 0 || nc >= set->cols) continue;
      float& ground = set->ground_m[set->IndexOf(nr, nc)];
      if (!std::isnan(ground)) continue;
      ground = GroundOf(columns, set->IndexOf(nr, nc), set->ground_m[set->IndexOf(r, c)], robot);
      if (!std::isnan(ground)) front.push_back({nr, nc});
    }
  }
}

/// Ground that is too steep, or stands a step above or below what lies `slope_span_m` away, carries no robot.
std::vector<uint8_t> FirmGround(const ReachableSet& set, const robots::RobotSpec& robot,
                                const ReachOptions& options) {
  const int span = std::max(1, static_cast<int>(std::lround(0.5 * options.slope_span_m / set.cell_m)));
  const float limit = static_cast<float>(robot.max_step_m) + 5e-3f;
  std::vector<uint8_t> firm(set.ground_m.size(), 0);
  for (int row = 0; row < set.rows; ++row) {
    for (int col = 0; col < set.cols; ++col) {
      if (std::isnan(set.ground_m[set.IndexOf(row, col)])) continue;
      const auto at = [&](int r, int c) {
        return set.ground_m[set.IndexOf(std::clamp(r, 0, set.rows - 1), std::clamp(c, 0, set.cols - 1))];
      };
      const float rise_y = std::abs(at(row + span, col) - at(row - span, col));
      const float rise_x = std::abs(at(row, col + span) - at(row, col - span));
      firm[set.IndexOf(row, col)] = !(rise_x > limit) && !(rise_y > limit);  // NaN: the circle test decides
    }
  }
  return firm;
}

/// Cells whose circle of `radius_m` lies wholly on firm ground.
std::vector<uint8_t> CirclesFree(const ReachableSet& set, const std::vector<uint8_t>& firm, double radius_m) {
  const int reach = static_cast<int>(std::ceil(radius_m / set.cell_m));
  std::vector<std::array<int, 2>> disc;
  for (int dr = -reach; dr <= reach; ++dr) {
    for (int dc = -reach; dc <= reach; ++dc) {
      if (std::hypot(dr, dc) * set.cell_m < radius_m) disc.push_back({dr, dc});
    }
  }
  std::vector<uint8_t> free = firm;
  for (int row = 0; row < set.rows; ++row) {
    for (int col = 0; col < set.cols; ++col) {
      // Nothing is known beyond the region.
      const int to_border = std::min({row, col, set.rows - 1 - row, set.cols - 1 - col});
      if (to_border < reach) free[set.IndexOf(row, col)] = 0;
      if (firm[set.IndexOf(row, col)] != 0) continue;
      bool on_border = false;  // only cells beside firm ground need stamping
      for (const auto& [dr, dc] : kSteps) {
        const int r = row + dr, c = col + dc;
        on_border |= r >= 0 && r < set.rows && c >= 0 && c < set.cols && firm[set.IndexOf(r, c)] != 0;
      }
      if (!on_border) continue;
      for (const auto& [dr, dc] : disc) {
        const int r = row + dr, c = col + dc;
        if (r >= 0 && r < set.rows && c >= 0 && c < set.cols) free[set.IndexOf(r, c)] = 0;
      }
    }
  }
  return free;
}

/// Kept free on either side of the robot where it walks straight on (TerrainParams::edge_clearance_m).
constexpr double kSideClearance_m = 0.10;

/// Free cells connected to the free cell nearest the spawn (within the robot's circle of it).
void FloodCenters(const std::vector<uint8_t>& free, const Vec3& spawn, double radius_m, ReachableSet* set) {
  double nearest = radius_m;
  std::deque<std::array<int, 2>> front;
  for (int row = 0; row < set->rows; ++row) {
    for (int col = 0; col < set->cols; ++col) {
      const double distance = (set->CenterOf(row, col) - spawn.head<2>()).norm();
      if (free[set->IndexOf(row, col)] == 0 || distance >= nearest) continue;
      nearest = distance;
      front = {{row, col}};
    }
  }
  if (front.empty()) return;
  set->reachable[set->IndexOf(front[0][0], front[0][1])] = 1;
  while (!front.empty()) {
    const auto [r, c] = front.front();
    front.pop_front();
    for (const auto& [dr, dc] : kSteps) {
      const int nr = r + dr, nc = c + dc;
      if (nr < 0 || nr >= set->rows || nc < 0 || nc >= set->cols) continue;
      uint8_t& reached = set->reachable[set->IndexOf(nr, nc)];
      if (reached != 0 || free[set->IndexOf(nr, nc)] == 0) continue;
      reached = 1;
      front.push_back({nr, nc});
    }
  }
}

}  // namespace

bool ReachableSet::CellUnder(const Vec2& p, int* row, int* col) const {
  const Vec2 cell = (p - origin) / cell_m;
  if (!(cell.x() >= 0.0 && cell.x() < cols && cell.y() >= 0.0 && cell.y() < rows)) return false;
  *col = static_cast<int>(cell.x());
  *row = static_cast<int>(cell.y());
  return true;
}

bool ReachableSet::ReachableAt(const Vec2& p) const {
  int row, col;
  return CellUnder(p, &row, &col) && reachable[IndexOf(row, col)] != 0;
}

double ReachableSet::AreaM2() const {
  return static_cast<double>(std::count(reachable.begin(), reachable.end(), uint8_t{1})) * cell_m * cell_m;
}

ReachableSet FindReachable(const scenes::SceneSpec& scene, const robots::RobotSpec& robot, const Box3& region,
                           const ReachOptions& options) {
  ReachableSet set;
  set.cell_m = options.cell_m;
  // A fraction of a cell off the round numbers that scenes are built on, so that walls do not lie on cell
  // borders.
  set.origin = region.min.head<2>() - Vec2::Constant(0.37 * options.cell_m);
  set.cols = static_cast<int>(std::ceil((region.max.x() - set.origin.x()) / set.cell_m));
  set.rows = static_cast<int>(std::ceil((region.max.y() - set.origin.y()) / set.cell_m));
  const size_t cells = static_cast<size_t>(set.rows) * set.cols;
  set.ground_m.assign(cells, kNoGround);
  set.reachable.assign(cells, 0);

  const Vec3 spawn = scene.T_map_spawn.translation();
  FloodGround(CutScene(scene, set, region), robot, spawn, &set);
  const std::vector<uint8_t> firm = FirmGround(set, robot, options);
  // It passes where its width fits, and stands, free to turn, where its circle does.
  FloodCenters(CirclesFree(set, firm, robot.half_width_m + kSideClearance_m), spawn, robot.footprint_radius_m,
               &set);
  const std::vector<uint8_t> standable = CirclesFree(set, firm, robot.footprint_radius_m);
  for (size_t i = 0; i < cells; ++i) set.reachable[i] &= standable[i];
  return set;
}

std::vector<Vec3> LatticePositions(const ReachableSet& set, const Vec3& spawn, double spacing_m) {
  const auto steps_to = [&](double v, double from) {
    return static_cast<int>(std::floor((v - from) / spacing_m));
  };
  const Vec2 far = set.origin + set.cell_m * Vec2(set.cols, set.rows);
  std::vector<Vec3> positions;
  for (int j = steps_to(set.origin.y(), spawn.y()); j <= steps_to(far.y(), spawn.y()); ++j) {
    for (int i = steps_to(set.origin.x(), spawn.x()); i <= steps_to(far.x(), spawn.x()); ++i) {
      const Vec2 p = spawn.head<2>() + spacing_m * Vec2(i, j);
      int row, col;
      if (!set.CellUnder(p, &row, &col) || set.reachable[set.IndexOf(row, col)] == 0) continue;
      positions.emplace_back(p.x(), p.y(), set.ground_m[set.IndexOf(row, col)]);
    }
  }
  return positions;
}

}  // namespace atlas::experiments
