// When mapping is done: thesis Eq. 3.8, as it stands and made scale-free.
#pragma once

#include <deque>

#include "core/params.h"

namespace atlas::planner {

/// Eq. 3.8 as it stands: no candidate of this plan reaches u_thres, in the gain's own unit. Where the best
/// one promises nothing at all there is nothing to go to, whatever the threshold.
inline bool BelowThreshold(double best_utility, double u_thres) {
  return best_utility < u_thres || best_utility <= 0.0;
}

/// Eq. 3.8 made scale-free.
struct TerminationParams {
  double stop_ratio = 0.025;  ///< of the greatest utility so far, mean over stop_rounds
  int stop_rounds = 4;        ///< the latest rounds, over which utility must be low and the surface flat
  double flat_share = 0.012;  ///< a sweep that adds less of all surface seen so far counts as flat
  int flat_rounds = 5;        ///< flat sweeps in a row that stop whatever views promise
  void Visit(core::ParamVisitor& v);
};

/// Eq. 3.8 stops when the best utility falls below a threshold; here the threshold is a share of the greatest
/// utility so far (the first view may see little), must be undercut over several rounds on average, and the
/// surface must have stopped growing over them too, by the measure that a flat coverage curve is judged by.
/// A gain that never falls (occlusion aware under clamped log-odds is worth more over free space than over
/// unknown) is overruled by a longer run of sweeps that brought nothing: another ending, by another name.
class Termination {
 public:
  explicit Termination(const TerminationParams& params) : params_(params) {}

  /// One plan: its best utility and the share of surface that the latest sweep added.
  void Observe(double best_utility, double latest_surface_share);
  bool GainExhausted() const { return Low() && Flat(); }
  bool SurfaceFlat() const { return flat_rounds_ >= params_.flat_rounds; }
  bool NothingWasPromised() const { return greatest_utility_ <= 0.0; }
  /// A plan of zero utility ends the mission if no plan ever had utility, or if the recent rounds were low.
  /// Else it may come too early: what earlier sweeps promised has only just been seen.
  bool NothingLeft() const { return NothingWasPromised() || Low(); }
  /// Latest best utility over the greatest so far.
  double ratio() const { return ratio_; }

 private:
  /// Whether the last stop_rounds plans promised little on average, and sweeps added little.
  bool Low() const;
  bool Flat() const;

  TerminationParams params_;
  double greatest_utility_ = 0.0;
  double ratio_ = 0.0;
  int flat_rounds_ = 0;
  std::deque<double> ratios_, shares_;  ///< of the last stop_rounds
};

}  // namespace atlas::planner
