#include "planner/planners/route_planner.h"

#include <fmt/format.h>

#include <optional>
#include <sstream>

#include "core/errors.h"

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

class RoutePlanner final : public NbvPlanner {
 public:
  explicit RoutePlanner(const std::vector<std::string>& stops) {
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

  void OnSweep(const core::Pose&, size_t) override {}

  NbvDecision Plan(const core::Pose& T_map_base, const mapping::MapView&,
                   const mapping::TraversableGround&) override {
    NbvDecision decision;
    if (at_ == last_view_) {
      decision.outcome = NbvOutcome::kRouteDone;
      return decision;
    }
    decision.path_map = {stops_[at_].p_map};
    do {
      ++at_;
      decision.path_length_m += (stops_[at_].p_map - decision.path_map.back()).norm();
      decision.path_map.push_back(stops_[at_].p_map);
    } while (!stops_[at_].yaw_rad);
    Candidate view;
    view.p_map = stops_[at_].p_map;
    view.yaw_rad = *stops_[at_].yaw_rad;
    view.ground_m = T_map_base.translation().z();
    view.path_length_m = decision.path_length_m;
    view.reason = LossReason::kChosen;
    decision.candidates = {view};
    decision.best = 0;
    decision.nodes_obtained = 1;
    decision.outcome = NbvOutcome::kView;
    return decision;
  }

 private:
  std::vector<Stop> stops_;
  size_t at_ = 0, last_view_ = 0;
};

}  // namespace

std::unique_ptr<NbvPlanner> MakeRoutePlanner(const std::vector<std::string>& stops) {
  return std::make_unique<RoutePlanner>(stops);
}

}  // namespace atlas::planner
