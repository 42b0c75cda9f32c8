// A planner that plans nothing: it visits the views it is given, in their order. For experiments in which all
// runs are to see from the same places. Ways between stops are straight, and begin at the stop before,
// wherever the robot believes to be. After the last view the route is done, and the mission with it.
#include <fmt/format.h>

#include <optional>
#include <sstream>

#include "core/errors.h"
#include "planner/planners/entries.h"

namespace atlas::planner {
namespace {

struct Stop {
  core::Vec2 p_map = core::Vec2::Zero();
  std::optional<double> yaw_rad;  ///< of a view
};

Stop ParseStop(const std::string& text) {
  std::istringstream in(text);
  Stop stop;
  double yaw_deg = 0.0;
  bool good = static_cast<bool>(in >> stop.p_map.x() >> stop.p_map.y()) && stop.p_map.allFinite();
  if (good && !(in >> std::ws).eof()) {
    good = static_cast<bool>(in >> yaw_deg) && std::isfinite(yaw_deg) && (in >> std::ws).eof();
    stop.yaw_rad = core::Radians(yaw_deg);
  }
  if (!good) {
    throw core::InputError(
        fmt::format("planner.route: '{}' is neither \"X Y\" (m) nor \"X Y YAW\" (m, m, deg)", text));
  }
  return stop;
}

class Route final : public Planner {
 public:
  Route(const std::vector<std::string>& stops, const RobotModel& robot) : robot_(robot) {
    bool any_view = false;
    for (const std::string& text : stops) {
      stops_.push_back(ParseStop(text));
      if (stops_.back().yaw_rad) last_view_ = stops_.size() - 1;
      any_view = any_view || stops_.back().yaw_rad;
    }
    if (stops_.size() < 2) {
      throw core::InputError(fmt::format("planner.route: {} stops; a route has at least two", stops_.size()));
    }
    if (!any_view) throw core::InputError("planner.route: no stop is a view (\"X Y YAW\")");
  }

  void OnScan(const ScanOutcome&, const core::PoseSource&) override {}

  Decision Plan(const Belief& belief, DecisionLog* log) override {
    if (at_ == last_view_) return Done{Done::Reason::kRouteDone};
    GoScan go;
    go.path_map = {stops_[at_].p_map};
    do {
      ++at_;
      log->path_length_m += (stops_[at_].p_map - go.path_map.back()).norm();
      go.path_map.push_back(stops_[at_].p_map);
    } while (!stops_[at_].yaw_rad);
    go.p_map = stops_[at_].p_map;
    go.yaw_rad = *stops_[at_].yaw_rad;
    Candidate view;
    view.p_map = go.p_map;
    view.yaw_rad = go.yaw_rad;
    view.ground_m = robot_.GroundUnder(belief.T_map_base);
    view.path_length_m = log->path_length_m;
    view.reason = LossReason::kChosen;
    log->candidates = {view};
    log->best = 0;
    log->nodes_obtained = 1;
    return go;
  }

 private:
  RobotModel robot_;
  std::vector<Stop> stops_;
  size_t at_ = 0, last_view_ = 0;
};

/// `route`: texts "X Y" (m, map frame: passed by) and "X Y YAW" (deg: a view), the first where the robot
/// starts; two at least, one of them a view.
class RouteParams final : public PlannerParamsOf<RouteParams> {
 public:
  void Visit(core::ParamVisitor& v) override {
    v.Field(
        "route", &route,
        {.doc = "stops \"X Y\" (m, passed by) and \"X Y YAW\" (deg, a view); the first is where the robot "
                "starts"});
  }
  std::unique_ptr<Planner> Build(const PlannerSetup& setup) const override {
    return std::make_unique<Route>(route, setup.robot);
  }

  std::vector<std::string> route;
};

}  // namespace

PlannerEntry RoutePlanner() {
  return {"route",
          "the views of planner.route in their order, so that runs differ in nothing but what they sense",
          [] { return std::unique_ptr<PlannerParams>(std::make_unique<RouteParams>()); }};
}

}  // namespace atlas::planner
