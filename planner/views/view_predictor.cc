#include "planner/views/view_predictor.h"

#include <algorithm>
#include <cmath>

namespace atlas::planner {
namespace {

using core::Vec2;
using core::Vec3;

constexpr const char* kSurfaceGain = "surface_frontier";

ViewTarget TargetOf(const PlannerSetup& setup) {
  return {.object_box = BoxOf(setup.goal), .seen_box = setup.kept_map};
}

}  // namespace

void ViewParams::Visit(core::ParamVisitor& v) {
  v.Field("nodes", &nodes, {.min = 1, .max = 10000, .doc = "places where views are evaluated (thesis: 150)"});
  v.Field("window_m", &window_m,
          {.unit = "m",
           .min = 2.0,
           .max = 30.0,
           .doc = "side of the square about the robot that views are sought in; what the elevation map does "
                  "not hold is not"});
  v.Field("headings", &headings, {.min = 1, .max = 64, .doc = "headings evaluated at every place"});
  v.Field("rays", &rays,
          {.min = 100, .max = 1000000, .doc = "rays of every view inside the object box, at least"});
  v.Field("max_range_m", &max_range_m,
          {.unit = "m", .min = 1.0, .max = 200.0, .doc = "range to which views are predicted"});
}

std::vector<std::string> GainRoles::names() const {
  std::vector<std::string> names = {deciding};
  const auto add = [&](const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  if (surface) add(kSurfaceGain);
  for (const std::string& name : extra) add(name);
  return names;
}

GainReads GainRoles::reads() const {
  GainReads all;
  for (const std::string& name : names()) {
    const GainReads& reads = FindGain(name).reads;
    all.each_free |= reads.each_free;
    all.each_unmeasured |= reads.each_unmeasured;
    all.behind_surface |= reads.behind_surface;
  }
  return all;
}

ViewPredictor::ViewPredictor(const ViewParams& params, const GainRoles& gains, const PlannerSetup& setup)
    : params_(params),
      gains_(gains),
      goal_box_(BoxOf(setup.goal)),
      evaluator_(setup.robot.sensor, TargetOf(setup), {gains.names(), params.rays, params.max_range_m}),
      threads_(setup.threads) {
  if (gains.surface) surface_column_ = ColumnOf(kSurfaceGain);
  for (const std::string& name : gains.extra) extra_columns_.push_back(ColumnOf(name));
}

size_t ViewPredictor::ColumnOf(const std::string& gain) const {
  const std::vector<std::string> names = gains_.names();
  return static_cast<size_t>(std::find(names.begin(), names.end(), gain) - names.begin());
}

/// Headings spread evenly, one pair of them broadside to the nearest point of the goal's box: a roll widens
/// the view abeam.
std::vector<double> ViewPredictor::HeadingsAt(const Vec2& p_map) const {
  const Vec2 nearest = p_map.cwiseMax(goal_box_.min.head<2>()).cwiseMin(goal_box_.max.head<2>());
  const Vec2 to_box =
      (nearest - p_map).norm() > 1e-6 ? nearest - p_map : Vec2(goal_box_.Center().head<2>() - p_map);
  const double broadside = std::atan2(to_box.y(), to_box.x()) + 0.5 * core::kPi;
  std::vector<double> yaw(static_cast<size_t>(params_.headings));
  for (int i = 0; i < params_.headings; ++i) {
    yaw[static_cast<size_t>(i)] = core::WrapAngle(broadside + 2.0 * core::kPi * i / params_.headings);
  }
  return yaw;
}

Candidate ViewPredictor::CandidateOf(const ViewGain& view) const {
  Candidate c;
  c.gain = view.gain.front();
  if (gains_.surface) c.surface_m2 = view.gain[surface_column_];
  for (const size_t column : extra_columns_) c.extra_gains.push_back(view.gain[column]);
  c.gain_void = view.by_end[static_cast<size_t>(EndClass::kVoid)];
  c.gain_ground = view.by_end[static_cast<size_t>(EndClass::kGround)];
  c.gain_object = view.by_end[static_cast<size_t>(EndClass::kObject)];
  return c;
}

void ViewPredictor::Predict(const mapping::MapView& map, const Ways& ways, DecisionLog* log) const {
  const std::vector<int> places = SpreadOut(ways.tree.nodes, ways.walkable.start().head<2>(), params_.nodes);
  std::vector<ViewNode> nodes;
  for (const int place : places) {
    const CandidateNode& node = ways.tree.nodes[static_cast<size_t>(place)];
    nodes.push_back({Vec3(node.p_map.x(), node.p_map.y(), node.ground_m), HeadingsAt(node.p_map)});
  }
  size_t rays = 0;
  const auto gains = evaluator_.Evaluate(map, nodes, threads_, &rays);
  log->rays_traced += rays;
  for (size_t i = 0; i < nodes.size(); ++i) {
    for (size_t h = 0; h < nodes[i].yaw_rad.size(); ++h) {
      Candidate c = CandidateOf(gains[i][h]);
      c.p_map = nodes[i].ground_map.head<2>();
      c.ground_m = nodes[i].ground_map.z();
      c.yaw_rad = nodes[i].yaw_rad[h];
      c.node = places[i];
      c.path_length_m = ways.tree.nodes[static_cast<size_t>(places[i])].path_length_m;
      log->candidates.push_back(std::move(c));
    }
  }
}

std::vector<double> ViewPredictor::BestFrom(const mapping::MapView& map, const std::vector<Vec3>& places_map,
                                            DecisionLog* log) const {
  std::vector<ViewNode> nodes;
  for (const Vec3& p : places_map) nodes.push_back({p, HeadingsAt(p.head<2>())});
  size_t rays = 0;
  std::vector<double> best(places_map.size(), 0.0);
  const auto gains = evaluator_.Evaluate(map, nodes, threads_, &rays);
  log->rays_traced += rays;
  for (size_t i = 0; i < gains.size(); ++i) {
    for (const ViewGain& view : gains[i]) best[i] = std::max(best[i], ValueOf(CandidateOf(view)));
  }
  return best;
}

}  // namespace atlas::planner
