#include "mapping/terrain/elevation_map.h"

#include <cmath>
#include <limits>
#include <utility>

#include "mapping/terrain/layered_grid.h"
#include "mapping/terrain/level_queries.h"
#include "mapping/terrain/ray_ingest.h"
#include "mapping/terrain/traversability.h"

namespace atlas::mapping {
namespace {

constexpr double kMargin_m = 0.8;       ///< about the window: a footprint at its border is judged too
constexpr double kStoreMargin_m = 2.0;  ///< about the window: what the store keeps beyond it
constexpr double kRecentre_m = 0.5;     ///< the store follows the robot in steps of about this
constexpr double kHeadroomMargin_m = 0.05;
constexpr double kFootSigma_m = 0.008;
constexpr float kSmoothQuery_m = 0.04f;  ///< heights this alike are interpolated between cells
constexpr double kWindowBelow_m = 4.0, kWindowAbove_m = 2.5;

int EvenCells(double metres, double cell_m) {
  return 2 * static_cast<int>(std::ceil(0.5 * metres / cell_m));
}

void MarkHeadroom(const terrain::HeadroomGrid& headroom, double cell_m, float headroom_m,
                  terrain::GroundImage* ground) {
  const float cell = static_cast<float>(cell_m);
  ground->headroom.assign(ground->kind.size(), 0);
  for (int r = 0; r < ground->side; ++r) {
    for (int c = 0; c < ground->side; ++c) {
      const size_t i = ground->Index(r, c);
      ground->headroom[i] = headroom.IsClear((static_cast<float>(ground->min_x + c) + 0.5f) * cell,
                                             (static_cast<float>(ground->min_y + r) + 0.5f) * cell,
                                             ground->reference_m[i], headroom_m);
    }
  }
}

}  // namespace

struct ElevationMap::Impl {
  Impl(const TerrainParams& p, const core::RobotExtent& r)
      : params(p),
        robot(r),
        grid(p.cell_m, EvenCells(p.window_m + 2.0 * kStoreMargin_m, p.cell_m)),
        headroom(p.window_m + 2.0 * kStoreMargin_m),
        ingest(&grid, &headroom),
        queries(params, robot, &published) {
    wave.link_m = static_cast<float>(p.negative_obstacle_m);
    wave.step_m = static_cast<float>(p.critical_step_m);
    wave.headroom_m = static_cast<float>(r.stance_height_m + r.body_top_m + kHeadroomMargin_m);
  }

  void MoveTo(const core::Pose& T_odom_base, double ground) {
    base = T_odom_base;
    ingest.SetGround(static_cast<float>(ground));
    const int ix = grid.IndexOf(base.translation().x()), iy = grid.IndexOf(base.translation().y());
    const int centre_x = grid.min_x() + grid.side() / 2, centre_y = grid.min_y() + grid.side() / 2;
    const int limit = static_cast<int>(kRecentre_m / params.cell_m);
    headroom.AddClearDisc(base.translation().head<2>(), robot.half_width_m, ground, ground + wave.headroom_m);
    if (std::abs(ix - centre_x) > limit || std::abs(iy - centre_y) > limit) grid.CenterOn(ix, iy);
  }

  TerrainParams params;
  core::RobotExtent robot;
  terrain::LayeredGrid grid;
  terrain::HeadroomGrid headroom;
  terrain::RayIngest ingest;
  terrain::WaveParams wave;
  terrain::Published published, fresh;
  bool refreshed = false;  ///< fresh is newer than published
  terrain::LevelQueries queries;
  core::Pose base = core::Pose::Identity();
  bool foot_down[4] = {false, false, false, false};
};

ElevationMap::ElevationMap(const TerrainParams& params, const core::RobotExtent& robot)
    : impl_(std::make_unique<Impl>(params, robot)) {}
ElevationMap::~ElevationMap() = default;

void ElevationMap::InitialiseUnderRobot(const core::Pose& T_odom_base) {
  Impl& m = *impl_;
  const double ground = T_odom_base.translation().z() - m.robot.stance_height_m;
  m.MoveTo(T_odom_base, ground);
  const double radius = m.params.initial_ground_radius_m;
  m.headroom.AddClearDisc(m.base.translation().head<2>(), radius, ground, ground + m.wave.headroom_m);
  const int reach = static_cast<int>(std::ceil(radius / m.params.cell_m));
  const int ix = m.grid.IndexOf(m.base.translation().x()), iy = m.grid.IndexOf(m.base.translation().y());
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      if (dx * dx + dy * dy > reach * reach || !m.grid.Contains(ix + dx, iy + dy)) continue;
      m.grid.Assume(m.grid.Slot(ix + dx, iy + dy), static_cast<float>(ground));
    }
  }
}

void ElevationMap::OnState(const core::StateEvent& event) {
  Impl& m = *impl_;
  double sum = 0.0;
  int down = 0;
  for (int foot = 0; foot < 4; ++foot) {
    if (!event.foot_in_contact[foot]) continue;
    sum += event.foot_odom[foot].z();
    ++down;
  }
  const double ground =
      down >= 2 ? sum / down : event.T_odom_base.translation().z() - m.robot.stance_height_m;
  m.MoveTo(event.T_odom_base, ground);
  for (int foot = 0; foot < 4; ++foot) {
    const bool landed = event.foot_in_contact[foot] && !m.foot_down[foot];
    m.foot_down[foot] = event.foot_in_contact[foot];
    if (landed) m.ingest.AddFoot(event.foot_odom[foot], kFootSigma_m);
  }
}

void ElevationMap::OnSpin(const std::shared_ptr<const core::SpinEvent>& spin) {
  impl_->ingest.AddSpin(*spin);
}

void ElevationMap::OnDepth(const core::DepthEvent& event) {
  Impl& m = *impl_;
  m.ingest.AddDepth(event, m.base, core::Vec2(m.robot.half_length_m, m.robot.half_width_m));
}

void ElevationMap::Update() {
  Refresh();
  Publish();
}

void ElevationMap::Publish() {
  if (!std::exchange(impl_->refreshed, false)) return;
  std::swap(impl_->published, impl_->fresh);
}

void ElevationMap::Refresh() {
  Impl& m = *impl_;
  const double cell = m.params.cell_m;
  const core::Vec2 robot = m.base.translation().head<2>();
  terrain::GroundImage where;
  where.side = EvenCells(m.params.window_m + 2.0 * kMargin_m, cell);
  where.min_x = m.grid.IndexOf(robot.x()) - where.side / 2;
  where.min_y = m.grid.IndexOf(robot.y()) - where.side / 2;
  std::vector<terrain::GroundImage> levels =
      FindLevels(m.wave, {robot, 0.5 * m.robot.half_width_m, m.ingest.ground_m()}, where, &m.grid);
  for (terrain::GroundImage& level : levels) MarkHeadroom(m.headroom, cell, m.wave.headroom_m, &level);
  const double reach = std::hypot(m.robot.half_length_m, m.robot.half_width_m);
  const int radius = static_cast<int>(
      std::ceil((std::max(reach, m.robot.footprint_radius_m) + 1.5 * m.params.edge_clearance_m) / cell) + 2);
  m.fresh.levels = AssessLevels(m.params, levels, where.side / 2, where.side / 2, radius);
  m.fresh.centre = robot;
  m.fresh.ground_m = m.ingest.ground_m();
  m.refreshed = true;
}

core::TerrainView::Ground ElevationMap::At(double x_odom, double y_odom) const {
  const Impl& m = *impl_;
  const int i = m.queries.IndexAt(x_odom, y_odom);
  Ground ground;
  if (i < 0) return ground;
  const terrain::TerrainImage& image = m.published.levels.front();
  const size_t at = static_cast<size_t>(i);
  const float own = image.height_m[at];
  ground.known = std::isfinite(own);
  if (!ground.known) return ground;
  ground.steppable = image.steppable[at] != 0;
  // Bilinear between the four nearest centres, of which those across an edge count as this cell.
  const double u = x_odom / m.params.cell_m - 0.5, v = y_odom / m.params.cell_m - 0.5;
  const int c = static_cast<int>(std::floor(u)), r = static_cast<int>(std::floor(v));
  const double fu = u - c, fv = v - r;
  double height = 0.0;
  for (int k = 0; k < 4; ++k) {
    const int col = c + (k & 1) - image.min_x, row = r + (k >> 1) - image.min_y;
    const double weight = ((k & 1) ? fu : 1.0 - fu) * ((k >> 1) ? fv : 1.0 - fv);
    float z = own;
    if (col >= 0 && row >= 0 && col < image.side && row < image.side) {
      const float other = image.height_m[image.Index(row, col)];
      if (std::abs(other - own) <= kSmoothQuery_m) z = other;
    }
    height += weight * z;
  }
  ground.height_m = height;
  return ground;
}

TraversableGround::Levels ElevationMap::LevelsAt(const core::Vec2& p_odom) const {
  return impl_->queries.LevelsAt(p_odom);
}
double ElevationMap::Traversability(const core::Vec3& p_odom) const {
  return impl_->queries.Traversability(p_odom);
}
GroundKind ElevationMap::KindAt(const core::Vec3& p_odom) const {
  return impl_->queries.KindAt(p_odom);
}
bool ElevationMap::FootprintFree(const core::Vec3& p_odom, double yaw_rad) const {
  return impl_->queries.FootprintFree(p_odom, yaw_rad);
}
bool ElevationMap::CircleFree(const core::Vec3& p_odom) const {
  return impl_->queries.CircleFree(p_odom);
}
ElevationMap::Surface ElevationMap::SurfaceAt(const core::Vec3& p_odom) const {
  return impl_->queries.SurfaceAt(p_odom);
}

core::Box3 ElevationMap::Window() const {
  const Impl& m = *impl_;
  const double half = 0.5 * m.params.window_m;
  core::Box3 box;
  box.min = {m.published.centre.x() - half, m.published.centre.y() - half,
             m.published.ground_m - kWindowBelow_m};
  box.max = {m.published.centre.x() + half, m.published.centre.y() + half,
             m.published.ground_m + kWindowAbove_m};
  return box;
}

ElevationMap::Grid ElevationMap::Export() const {
  const Impl& m = *impl_;
  const core::Box3 window = Window();
  const int min_x = m.grid.IndexOf(window.min.x()), min_y = m.grid.IndexOf(window.min.y());
  Grid out;
  out.cell_m = m.params.cell_m;
  out.rows = out.cols = static_cast<int>(std::lround(m.params.window_m / m.params.cell_m));
  out.origin = core::Vec2(min_x, min_y) * m.params.cell_m;
  for (int r = 0; r < out.rows; ++r) {
    for (int c = 0; c < out.cols; ++c) {
      const int i = m.queries.IndexAt((min_x + c + 0.5) * out.cell_m, (min_y + r + 0.5) * out.cell_m);
      const size_t at = static_cast<size_t>(i);
      const terrain::TerrainImage* image = i < 0 ? nullptr : &m.published.levels.front();
      out.height_m.push_back(image == nullptr ? std::numeric_limits<float>::quiet_NaN()
                                              : image->height_m[at]);
      out.traversability.push_back(image == nullptr ? 0.0f : image->traversability[at]);
      out.kind.push_back(image == nullptr ? GroundKind::kUnknown : image->kind[at]);
    }
  }
  return out;
}

}  // namespace atlas::mapping
