// Next-Best-View planning: candidates, gains, costs, utility, path (thesis 3.4, 3.5).
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/lidar_model.h"
#include "core/params.h"
#include "core/rng.h"
#include "mapping/terrain/elevation_map.h"
#include "planner/gain/view_evaluator.h"
#include "planner/planner.h"

namespace atlas::planner {

struct NbvParams {
  std::string name = "greedy";  ///< thesis | greedy | route
  std::string gain = "occlusion_aware_normalised";
  /// Greedy: views are worth the surface that they uncover (surface_frontier), modulated by `gain`: of two
  /// views that uncover alike, the one with the plan's best gain is worth up to this share more. 1 decides by
  /// `gain` alone.
  double gain_share = 0.3;
  std::vector<std::string> extra_gains;  ///< also computed and logged for every candidate, from the same rays
  int nodes = 150;
  double window_m = 16.0;  ///< side of the square about the robot that views are sought in (thesis: 12)
  /// Greedy: places found walkable by earlier plans stay candidates beyond the window.
  bool roadmap = true;
  double lattice_m = 0.5;  ///< greedy: spacing of the places considered
  /// Greedy, where the robot fits but cannot turn: `lattice` steps between places that happen to face each
  /// other across it; `centred` finds doorways wherever they are and walks through their middle.
  std::string passages = "lattice";
  double rrt_step_m = 0.6;
  int headings = 8;
  int rays = 5000;  ///< per candidate inside the object box, at least
  double max_range_m = 20.0;
  /// What a map holds of places seen from afar only cannot be trusted (a doorway seen along its wall looks
  /// shut), nor what views promise there. So a view is worth up to this much more, the further from all scans
  /// it stands beyond the distance given; 0: no more.
  double unvisited_m2 = 0.0;
  double unvisited_beyond_m = 5.0;
  /// Views about a place whose promise was broken are worth less, by 1 - exp(-(d / this)^2) for each at a
  /// distance d; 0: no less.
  double distrust_m = 6.0;
  // Position cost (Eq. 3.7) as two terms; the maximum of both equals the thesis's at equal thresholds.
  bool visited_cost = true;
  double visited_threshold_m = 2.0;
  bool too_close_cost = true;
  double too_close_threshold_m = 1.5;
  double behind_penalty = 0.2;           ///< constant traversal cost for candidates behind the robot
  std::string traversal = "continuous";  ///< discrete (thesis) | continuous (time, slope, roughness, turning)
  double time_scale_s = 60.0;            ///< continuous: travel of this long costs 1 - 1/e
  /// thesis: u_thres of Eq. 3.8, nats over all rays of a sweep. The thesis gives no value. Occlusion aware
  /// never comes near it: void rays keep their unknown voxels, and known free space is worth more than
  /// unknown.
  double stop_utility = 0.0;
  // greedy: Eq. 3.8 made scale-free.
  double stop_ratio = 0.025;  ///< of the greatest utility so far, mean over stop_rounds
  int stop_rounds = 4;        ///< rounds that count
  double flat_share = 0.012;  ///< a sweep that adds less of all surface seen so far counts as flat
  int flat_rounds = 5;        ///< flat sweeps in a row that stop whatever views promise
  double commit_margin =
      0.15;                 ///< hysteresis: a commitment stays unless another is this much better; 0: none
  int blacklist_after = 2;  ///< views that gained nothing here so often are dropped; 0: never
  /// At the end: views beyond a way too narrow for the robot promise more if worth this share of the best of
  /// all plans.
  double blocked_share = 0.2;
  int rrt_star_iterations = 800;
  std::vector<std::string> route;  ///< route: where to go (planner/planners/route_planner.h)
  mapping::TerrainParams terrain;
  void Visit(core::ParamVisitor& v);
};

struct PlannerEntry {
  std::string name;
  std::string doc;
};
const std::vector<PlannerEntry>& PlannerCatalog();

/// The planner's own defaults: `thesis` decides as the thesis's does (3.4, 3.5), `greedy` is what a default
/// NbvParams holds. @throws InputError for an unknown name.
NbvParams DefaultParams(const std::string& name);

/// What the planner's gains read of the map.
GainReads ReadsOf(const NbvParams& params);

/// What the planner expects of the robot.
struct RobotModel {
  SweepSensorModel sensor;
  double speed_mps = 0.5;                               ///< on flat smooth ground
  double half_width_m = 0.33, turning_radius_m = 0.55;  ///< of the footprint
};

/// @throws InputError for an unknown planner or gain.
std::unique_ptr<NbvPlanner> MakeNbvPlanner(const NbvParams& params, const RobotModel& robot,
                                           const ViewTarget& target, int threads, const core::Rng& rng);

}  // namespace atlas::planner
