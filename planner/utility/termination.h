// When mapping is done: thesis Eq. 3.8 made scale-free.
#pragma once

namespace atlas::planner {

struct TerminationParams {
  double stop_ratio = 0.05;  ///< of the first view's utility
  double flat_share = 0.01;  ///< a sweep that adds less of all surface seen so far adds nothing
  int stop_rounds = 2;       ///< low rounds in a row
  int flat_rounds = 3;       ///< flat sweeps in a row that end the mission whatever is promised
};

/// Eq. 3.8 stops when the best utility falls below a threshold; here the threshold is a share of the first
/// view's utility, must be undercut in several rounds running, and the surface must have stopped growing too.
/// A gain that never falls (occlusion aware under clamped log-odds is worth more over free space than over
/// unknown) is overruled by a longer run of sweeps that brought nothing.
class Termination {
 public:
  explicit Termination(const TerminationParams& params) : params_(params) {}

  /// One plan: its best utility and the share of surface that the latest sweep added.
  void Observe(double best_utility, double latest_surface_share);
  bool Exhausted() const { return low_rounds_ >= params_.stop_rounds || flat_rounds_ >= params_.flat_rounds; }
  /// Latest best utility over the first one's.
  double ratio() const { return ratio_; }

 private:
  TerminationParams params_;
  double first_utility_ = 0.0;
  double ratio_ = 0.0;
  int low_rounds_ = 0, flat_rounds_ = 0;
};

}  // namespace atlas::planner
