// The improved planner for objects: lattice views worth the surface that they uncover, continuous traversal
// cost, memory of promises that were broken.
#include "planner/planners/entries.h"
#include "planner/planners/surface_planner.h"

namespace atlas::planner {
namespace {

class GreedyParams final : public SurfaceParamsOf<GreedyParams> {
 public:
  void Visit(core::ParamVisitor& v) override {
    surface.VisitShared(v);
    v.Field("roadmap", &surface.places.roadmap,
            {.doc = "places that earlier plans found walkable stay candidates beyond the window"});
    v.Field("passages", &surface.places.passages,
            {.choices = {"lattice", "centred"},
             .doc = "through doorways: steps of the lattice that happen to fit, or their middle"});
    v.Field("distrust_m", &surface.distrust_m,
            {.unit = "m",
             .min = 0.0,
             .max = 100.0,
             .doc = "views about this near to one that brought nothing are worth less; 0: no less"});
  }
};

}  // namespace

PlannerEntry GreedyPlanner() {
  return {"greedy", "lattice views worth the surface they uncover, continuous traversal cost",
          [] { return std::unique_ptr<PlannerParams>(std::make_unique<GreedyParams>()); }};
}

}  // namespace atlas::planner
