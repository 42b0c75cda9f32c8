// What `greedy` and `explore` share: lattice views worth the surface that they uncover.
#pragma once

#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "planner/planners/gain_params.h"
#include "planner/planners/nbv_parts.h"
#include "planner/stopping/termination.h"

namespace atlas::planner {

/// Where views are sought.
struct PlaceParams {
  double lattice_m = 0.5;  ///< spacing of the places considered
  /// Places found walkable by earlier plans stay candidates beyond the window.
  bool roadmap = true;
  /// Where the robot fits but cannot turn: `lattice` steps between places that happen to face each other
  /// across it; `centred` finds doorways wherever they are and walks through their middle.
  std::string passages = "lattice";
  double rrt_step_m = 0.6;  ///< where the lattice has no place
};

struct SurfaceParams {
  GainParams gains{.gain = "occlusion_aware_normalised", .extra_gains = {}};
  /// Views are worth the surface that they uncover (surface_frontier), modulated by the gain: of two views
  /// that uncover alike, the one with the plan's best gain is worth up to this share more. 1 decides by the
  /// gain alone.
  double gain_share = 0.3;
  NbvParams nbv;
  PlaceParams places;
  /// What a map holds of places seen from afar only cannot be trusted (a doorway seen along its wall looks
  /// shut), nor what views promise there. So a view is worth up to this much more, the further from all scans
  /// it stands beyond the distance given; 0: no more.
  double unvisited_m2 = 0.0;
  double unvisited_beyond_m = 5.0;
  /// Views about a place whose promise was broken are worth less, by 1 - exp(-(d / this)^2) for each at a
  /// distance d; 0: no less.
  double distrust_m = 6.0;
  double commit_margin = 0.15;  ///< hysteresis: a commitment stays unless another is this much better
  int blacklist_after = 2;      ///< views that gained nothing here so often are dropped; 0: never
  TerminationParams stopping;

  bool DecidesBySurface() const { return gain_share < 1.0; }
  GainRoles Roles() const {
    return {.deciding = gains.gain, .surface = DecidesBySurface(), .extra = gains.extra_gains};
  }
  /// Fields that both planners have.
  void VisitShared(core::ParamVisitor& v);
};

/// @throws InputError for an unknown gain.
std::unique_ptr<Planner> MakeSurfacePlanner(const SurfaceParams& params, const PlannerSetup& setup);

/// The answers of a PlannerParams that holds SurfaceParams.
template <typename Params>
class SurfaceParamsOf : public PlannerParamsOf<Params> {
 public:
  std::unique_ptr<Planner> Build(const PlannerSetup& setup) const final {
    return MakeSurfacePlanner(surface, setup);
  }
  double window_m() const final { return surface.nbv.views.window_m; }
  std::string gain() const final { return surface.gains.gain; }
  std::string worth() const final {
    if (!surface.DecidesBySurface()) return "";
    return fmt::format("surface_frontier x {} ({:.0f} %)", surface.gains.gain, 100.0 * surface.gain_share);
  }
  std::vector<std::string> extra_gains() const final { return surface.gains.extra_gains; }
  GainReads reads() const final { return surface.Roles().reads(); }

  SurfaceParams surface;
};

}  // namespace atlas::planner
