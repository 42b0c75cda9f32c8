#include "planner/gain/gain.h"
#include "planner/planners/nbv_planner.h"

namespace atlas::planner {
namespace {

std::vector<std::string> PlannerNames() {
  std::vector<std::string> names;
  for (const PlannerEntry& entry : PlannerCatalog()) names.push_back(entry.name);
  return names;
}

void VisitCosts(core::ParamVisitor& v, NbvParams* p) {
  v.Field("visited_cost", &p->visited_cost, {.doc = "position cost near places already scanned (Eq. 3.7)"});
  v.Field("visited_threshold_m", &p->visited_threshold_m,
          {.unit = "m", .min = 0.05, .max = 20.0, .doc = "d_thres of the visited term"});
  v.Field("too_close_cost", &p->too_close_cost, {.doc = "position cost near the object (Eq. 3.7)"});
  v.Field("too_close_threshold_m", &p->too_close_threshold_m,
          {.unit = "m", .min = 0.05, .max = 20.0, .doc = "d_thres of the too-close term"});
  v.Field(
      "behind_penalty", &p->behind_penalty,
      {.min = 0.0, .max = 1.0, .doc = "constant traversal cost of views behind the robot (thesis 3.4.2)"});
  v.Field("traversal", &p->traversal,
          {.choices = {"discrete", "continuous"},
           .doc = "discrete: reachable costs nothing (thesis); continuous: time, slope, roughness, turning"});
  v.Field("time_scale_s", &p->time_scale_s,
          {.unit = "s", .min = 1.0, .max = 1e6, .doc = "continuous: a way of this long costs 1 - 1/e"});
}

void VisitMemory(core::ParamVisitor& v, NbvParams* p) {
  v.Field("unvisited_m2", &p->unvisited_m2,
          {.unit = "m^2",
           .min = 0.0,
           .max = 1000.0,
           .doc = "what views far from all scans are worth besides, at most"});
  v.Field("unvisited_beyond_m", &p->unvisited_beyond_m,
          {.unit = "m", .min = 0.5, .max = 100.0, .doc = "far from all scans is farther than this"});
  v.Field("distrust_m", &p->distrust_m,
          {.unit = "m",
           .min = 0.0,
           .max = 100.0,
           .doc = "views about this near to one that brought nothing are worth less; 0: no less"});
  v.Field("commit_margin", &p->commit_margin,
          {.min = 0.0, .max = 10.0, .doc = "a commitment stays unless another view is this much better"});
  v.Field("blacklist_after", &p->blacklist_after,
          {.min = 0,
           .max = 100,
           .doc = "views here that brought nothing, before the place is dropped; 0: never"});
  v.Field(
      "blocked_share", &p->blocked_share,
      {.min = 0.0,
       .max = 1.0,
       .doc = "views beyond a way too narrow keep the mission from being completed if worth this share of "
              "the best of all plans"});
}

/// Eq. 3.8.
void VisitThreshold(core::ParamVisitor& v, NbvParams* p) {
  v.Field("stop_utility", &p->stop_utility,
          {.unit = "nats",
           .min = 0.0,
           .max = 1e9,
           .doc = "u_thres of Eq. 3.8: stop where no view's utility reaches this; occlusion aware never "
                  "falls so low"});
}

/// Eq. 3.8 made scale-free.
void VisitRatio(core::ParamVisitor& v, NbvParams* p) {
  v.Field(
      "stop_ratio", &p->stop_ratio,
      {.min = 0.0,
       .max = 1.0,
       .doc =
           "stop where utility, mean of stop_rounds, falls below this share of the greatest so far (Eq. 3.8, "
           "scale-free)"});
  v.Field("stop_rounds", &p->stop_rounds,
          {.min = 1, .max = 100, .doc = "latest rounds over which utility must be low and the surface flat"});
  v.Field(
      "flat_share", &p->flat_share,
      {.min = 0.0, .max = 1.0, .doc = "a sweep that adds less of the surface seen so far counts as flat"});
  v.Field("flat_rounds", &p->flat_rounds,
          {.min = 1, .max = 100, .doc = "flat sweeps in a row that stop the mission whatever views promise"});
}

/// How greedy picks places and values views.
void VisitLattice(core::ParamVisitor& v, NbvParams* p) {
  v.Field("gain_share", &p->gain_share,
          {.min = 0.0,
           .max = 1.0,
           .doc = "how far the gain modulates the surface that a view uncovers; 1: gain alone"});
  v.Field("roadmap", &p->roadmap,
          {.doc = "places that earlier plans found walkable stay candidates beyond the window"});
  v.Field("lattice_m", &p->lattice_m,
          {.unit = "m", .min = 0.1, .max = 5.0, .doc = "spacing of the places considered"});
  v.Field("passages", &p->passages,
          {.choices = {"lattice", "centred"},
           .doc = "through doorways: steps of the lattice that happen to fit, or their middle"});
}

/// Of the planners that plan; `none` takes what another one has.
void VisitPlanning(core::ParamVisitor& v, core::ParamVisitor& none, NbvParams* p) {
  v.Field("gain", &p->gain,
          {.choices = GainNames(),
           .doc = "information gain that decides; greedy: that modulates what decides, the surface that a "
                  "view uncovers (gain_share)"});
  v.Field("extra_gains", &p->extra_gains,
          {.choices = GainNames(), .doc = "also computed from the same rays and logged for every candidate"});
  v.Field("nodes", &p->nodes,
          {.min = 1, .max = 10000, .doc = "places where views are evaluated (thesis: 150)"});
  v.Field("window_m", &p->window_m,
          {.unit = "m",
           .min = 2.0,
           .max = 100.0,
           .doc = "side of the square about the robot that views are sought in; what the elevation map does "
                  "not hold is not"});
  v.Field("rrt_step_m", &p->rrt_step_m,
          {.unit = "m", .min = 0.1, .max = 5.0, .doc = "longest edge of the RRT"});
  v.Field("headings", &p->headings, {.min = 1, .max = 64, .doc = "headings evaluated at every place"});
  v.Field("rays", &p->rays,
          {.min = 100, .max = 1000000, .doc = "rays of every view inside the object box, at least"});
  v.Field("max_range_m", &p->max_range_m,
          {.unit = "m", .min = 1.0, .max = 200.0, .doc = "range to which views are predicted"});
  VisitCosts(v, p);
  VisitMemory(v, p);
  const bool thesis = p->name == "thesis";
  VisitLattice(thesis ? none : v, p);
  VisitThreshold(thesis ? v : none, p);
  VisitRatio(thesis ? none : v, p);
  v.Field("rrt_star_iterations", &p->rrt_star_iterations,
          {.min = 0, .max = 100000, .doc = "iterations of RRT* on the way to the view"});
}

}  // namespace

void NbvParams::Visit(core::ParamVisitor& v) {
  v.Field("name", &name,
          {.choices = PlannerNames(),
           .doc = "thesis: as thesis 3.4, 3.5; greedy: the improved one; route: given views, in order"});
  core::AbsentFields absent(&v, "planner.name = " + name);
  core::ParamVisitor& none = absent;
  const bool is_route = name == "route";
  (is_route ? v : none)
      .Field(
          "route", &route,
          {.doc = "stops \"X Y\" (m, passed by) and \"X Y YAW\" (deg, a view); the first is where the robot "
                  "starts"});
  VisitPlanning(is_route ? none : v, none, this);
  v.Section("terrain", &terrain);
}

}  // namespace atlas::planner
