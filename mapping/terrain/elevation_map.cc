#include "mapping/terrain/elevation_map.h"

#include <cmath>
#include <limits>
#include <utility>

#include "mapping/terrain/layered_grid.h"
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
        ingest(&grid, &headroom) {
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

  /// Index into the published image, or -1 outside.
  int IndexAt(double x, double y) const {
    const int c = grid.IndexOf(x) - image.min_x, r = grid.IndexOf(y) - image.min_y;
    if (c < 0 || r < 0 || c >= image.side || r >= image.side) return -1;
    return r * image.side + c;
  }

  double clearance_m(double x, double y, const std::vector<int16_t>& distance2) const {
    const int i = IndexAt(x, y);
    return i < 0 ? 0.0 : params.cell_m * std::sqrt(distance2[static_cast<size_t>(i)]);
  }

  /// No cell at distance 0 has its centre in the rectangle: halved until a distance decides.
  bool RectangleClear(const core::Vec2& centre, const core::Vec2& along, double half_length,
                      double half_width, const std::vector<int16_t>& distance2) const {
    const int i = IndexAt(centre.x(), centre.y());
    if (i < 0 || distance2[static_cast<size_t>(i)] == 0) return false;
    const double reach = std::hypot(half_length, half_width);
    if (reach <= 0.5 * params.cell_m) return true;
    const double clear = params.cell_m * std::sqrt(distance2[static_cast<size_t>(i)]);
    if (clear > reach + 0.71 * params.cell_m) return true;
    if (half_length >= half_width) {
      const core::Vec2 shift = 0.5 * half_length * along;
      return RectangleClear(centre - shift, along, 0.5 * half_length, half_width, distance2) &&
             RectangleClear(centre + shift, along, 0.5 * half_length, half_width, distance2);
    }
    const core::Vec2 shift = 0.5 * half_width * core::Vec2(-along.y(), along.x());
    return RectangleClear(centre - shift, along, half_length, 0.5 * half_width, distance2) &&
           RectangleClear(centre + shift, along, half_length, 0.5 * half_width, distance2);
  }

  TerrainParams params;
  core::RobotExtent robot;
  terrain::LayeredGrid grid;
  terrain::HeadroomGrid headroom;
  terrain::RayIngest ingest;
  terrain::WaveParams wave;
  terrain::GroundImage ground;
  /// What queries read, and where the robot was then.
  struct Published {
    terrain::TerrainImage image;
    core::Vec2 centre = core::Vec2::Zero();
    float ground_m = 0.0f;
  };
  Published published, fresh;
  bool refreshed = false;  ///< fresh is newer than published
  const terrain::TerrainImage& image = published.image;
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
  m.ground.side = EvenCells(m.params.window_m + 2.0 * kMargin_m, cell);
  m.ground.min_x = m.grid.IndexOf(robot.x()) - m.ground.side / 2;
  m.ground.min_y = m.grid.IndexOf(robot.y()) - m.ground.side / 2;
  FindGround(m.wave, robot, 0.5 * m.robot.half_width_m, m.ingest.ground_m(), &m.grid, &m.ground);
  MarkHeadroom(m.headroom, cell, m.wave.headroom_m, &m.ground);
  const double reach = std::hypot(m.robot.half_length_m, m.robot.half_width_m);
  const int radius = static_cast<int>(
      std::ceil((std::max(reach, m.robot.footprint_radius_m) + 1.5 * m.params.edge_clearance_m) / cell) + 2);
  m.fresh.image = AssessTerrain(m.params, m.ground, m.ground.side / 2, m.ground.side / 2, radius);
  m.fresh.centre = robot;
  m.fresh.ground_m = m.ingest.ground_m();
  m.refreshed = true;
}

core::TerrainView::Ground ElevationMap::At(double x_odom, double y_odom) const {
  const Impl& m = *impl_;
  const int i = m.IndexAt(x_odom, y_odom);
  Ground ground;
  if (i < 0) return ground;
  const size_t at = static_cast<size_t>(i);
  const float own = m.image.height_m[at];
  ground.known = std::isfinite(own);
  if (!ground.known) return ground;
  ground.steppable = m.image.steppable[at] != 0;
  // Bilinear between the four nearest centres, of which those across an edge count as this cell.
  const double u = x_odom / m.params.cell_m - 0.5, v = y_odom / m.params.cell_m - 0.5;
  const int c = static_cast<int>(std::floor(u)), r = static_cast<int>(std::floor(v));
  const double fu = u - c, fv = v - r;
  double height = 0.0;
  for (int k = 0; k < 4; ++k) {
    const int col = c + (k & 1) - m.image.min_x, row = r + (k >> 1) - m.image.min_y;
    const double weight = ((k & 1) ? fu : 1.0 - fu) * ((k >> 1) ? fv : 1.0 - fv);
    float z = own;
    if (col >= 0 && row >= 0 && col < m.image.side && row < m.image.side) {
      const float other = m.image.height_m[m.image.Index(row, col)];
      if (std::abs(other - own) <= kSmoothQuery_m) z = other;
    }
    height += weight * z;
  }
  ground.height_m = height;
  return ground;
}

double ElevationMap::Traversability(const core::Vec2& p_odom) const {
  const int i = impl_->IndexAt(p_odom.x(), p_odom.y());
  return i < 0 ? 0.0 : impl_->image.traversability[static_cast<size_t>(i)];
}

GroundKind ElevationMap::KindAt(const core::Vec2& p_odom) const {
  const int i = impl_->IndexAt(p_odom.x(), p_odom.y());
  return i < 0 ? GroundKind::kUnknown : impl_->image.kind[static_cast<size_t>(i)];
}

bool ElevationMap::FootprintFree(const core::Vec2& p_odom, double yaw_rad) const {
  const Impl& m = *impl_;
  const core::Vec2 along(std::cos(yaw_rad), std::sin(yaw_rad));
  const double rim = m.params.edge_clearance_m;
  return m.RectangleClear(p_odom, along, m.robot.half_length_m, m.robot.half_width_m,
                          m.image.distance2_blocked) &&
         m.RectangleClear(p_odom, along, m.robot.half_length_m + rim, m.robot.half_width_m + rim,
                          m.image.distance2_open);
}

bool ElevationMap::CircleFree(const core::Vec2& p_odom) const {
  const Impl& m = *impl_;
  const double radius = m.robot.footprint_radius_m;
  return m.clearance_m(p_odom.x(), p_odom.y(), m.image.distance2_blocked) >= radius &&
         m.clearance_m(p_odom.x(), p_odom.y(), m.image.distance2_open) >= radius + m.params.edge_clearance_m;
}

ElevationMap::Surface ElevationMap::SurfaceAt(const core::Vec2& p_odom) const {
  const Impl& m = *impl_;
  Surface surface;
  surface.height_m = m.published.ground_m;
  const int i = m.IndexAt(p_odom.x(), p_odom.y());
  if (i < 0) return surface;
  const int row = i / m.image.side, col = i % m.image.side;
  const terrain::PlaneFits& planes = m.image.planes;
  const size_t block =
      static_cast<size_t>(row / 2) * static_cast<size_t>(planes.cols) + static_cast<size_t>(col / 2);
  if (!std::isfinite(planes.height_m[block])) return surface;
  surface.height_m = planes.height_m[block];
  surface.slope_rad = planes.slope_rad[block];
  surface.roughness_m = planes.roughness_m[block];
  return surface;
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
      const int i = m.IndexAt((min_x + c + 0.5) * out.cell_m, (min_y + r + 0.5) * out.cell_m);
      out.height_m.push_back(i < 0 ? std::numeric_limits<float>::quiet_NaN()
                                   : m.image.height_m[static_cast<size_t>(i)]);
      out.traversability.push_back(i < 0 ? 0.0f : m.image.traversability[static_cast<size_t>(i)]);
      out.kind.push_back(i < 0 ? GroundKind::kUnknown : m.image.kind[static_cast<size_t>(i)]);
    }
  }
  return out;
}

}  // namespace atlas::mapping
