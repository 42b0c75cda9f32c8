// The views that a plan considers, and what each is predicted to gain.
#pragma once

#include <string>
#include <vector>

#include "core/params.h"
#include "planner/decision.h"
#include "planner/gain/view_evaluator.h"
#include "planner/views/candidates.h"
#include "planner/views/planner_setup.h"

namespace atlas::planner {

/// Where views are sought and how finely they are predicted.
struct ViewParams {
  int nodes = 150;
  double window_m = 16.0;  ///< side of the square about the robot (thesis: 12)
  int headings = 8;
  int rays = 5000;  ///< per candidate inside the goal's box, at least
  double max_range_m = 20.0;
  void Visit(core::ParamVisitor& v);
};

/// Gains by what they are for.
struct GainRoles {
  std::string deciding;            ///< Candidate::gain; its split by where rays end is logged
  bool surface = false;            ///< Candidate::surface_m2: surface_frontier decides, too
  std::vector<std::string> extra;  ///< Candidate::extra_gains: logged only

  /// Each once, the deciding one first.
  std::vector<std::string> names() const;
  /// What they read of the map. @throws InputError for an unknown gain.
  GainReads reads() const;
};

/// Immutable after construction.
class ViewPredictor {
 public:
  /// @throws InputError for an unknown gain.
  ViewPredictor(const ViewParams& params, const GainRoles& gains, const PlannerSetup& setup);

  /// Fills the log's candidates: each heading of places of the tree that are spread out.
  void Predict(const mapping::MapView& map, const Ways& ways, DecisionLog* log) const;
  /// The most that a view from each of these ground points is worth, as ValueOf has it; adds to the log's
  /// rays.
  std::vector<double> BestFrom(const mapping::MapView& map, const std::vector<core::Vec3>& places_map,
                               DecisionLog* log) const;
  /// What views are compared by, before anything modulates it: the surface where that decides, else the gain.
  /// @pre the view was predicted.
  double ValueOf(const Candidate& view) const { return gains_.surface ? *view.surface_m2 : *view.gain; }

  double sensor_height_m() const { return evaluator_.view().sensor_height_m(); }
  const core::Box3& goal_box() const { return goal_box_; }
  double max_range_m() const { return params_.max_range_m; }

 private:
  size_t ColumnOf(const std::string& gain) const;
  std::vector<double> HeadingsAt(const core::Vec2& p_map) const;
  Candidate CandidateOf(const ViewGain& view) const;

  ViewParams params_;
  GainRoles gains_;
  core::Box3 goal_box_;
  ViewEvaluator evaluator_;
  int threads_;
  size_t surface_column_ = 0;
  std::vector<size_t> extra_columns_;
};

}  // namespace atlas::planner
