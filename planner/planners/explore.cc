// The planner for spaces: as `greedy`, but views far from all scans are worth more, doorways are walked
// through their middle, and one room of many is enough to go on for.
#include "planner/planners/entries.h"
#include "planner/planners/surface_planner.h"

namespace atlas::planner {
namespace {

class ExploreParams final : public SurfaceParamsOf<ExploreParams> {
 public:
  ExploreParams() {
    surface.places.passages = "centred";       // doorways of 0.9 m lie beside the lattice
    surface.unvisited_m2 = 2.0;                // corners that were seen from afar only
    surface.distrust_m = 0.0;                  // a place that brings nothing says little of the next room
    surface.nbv.costs.too_close_cost = false;  // rooms are narrow: every place is close to a wall
    surface.nbv.costs.visited_threshold_m = 1.5;
    surface.stopping.stop_ratio = 0.005;  // a far room is a long walk: utility is low before it is seen
    surface.stopping.flat_share = 0.004;  // one room of many adds a small share
    surface.stopping.flat_rounds = 12;    // the last room may lie behind many places that bring nothing
  }
  void Visit(core::ParamVisitor& v) override {
    surface.VisitShared(v);
    v.Field("unvisited_m2", &surface.unvisited_m2,
            {.unit = "m^2",
             .min = 0.0,
             .max = 1000.0,
             .doc = "what views far from all scans are worth besides, at most"});
    v.Field("unvisited_beyond_m", &surface.unvisited_beyond_m,
            {.unit = "m", .min = 0.5, .max = 100.0, .doc = "far from all scans is farther than this"});
  }
};

}  // namespace

PlannerEntry ExplorePlanner() {
  return {"explore", "as greedy, for spaces: far places are worth more, doorways are passed in their middle",
          [] { return std::unique_ptr<PlannerParams>(std::make_unique<ExploreParams>()); }};
}

}  // namespace atlas::planner
