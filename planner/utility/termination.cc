#include "planner/utility/termination.h"

namespace atlas::planner {
namespace {

/// A sweep that adds more of the surface than this speaks against stopping, whatever views promise.
constexpr double kStillGrowing = 0.03;

}  // namespace

void Termination::Observe(double best_utility, double latest_surface_share) {
  if (first_utility_ <= 0.0) first_utility_ = best_utility;
  ratio_ = first_utility_ > 0.0 ? best_utility / first_utility_ : 0.0;
  const bool flat = latest_surface_share < params_.flat_share;
  flat_rounds_ = flat ? flat_rounds_ + 1 : 0;
  const bool low = ratio_ < params_.stop_ratio && latest_surface_share < kStillGrowing;
  low_rounds_ = low ? low_rounds_ + 1 : 0;
}

}  // namespace atlas::planner
