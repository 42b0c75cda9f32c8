#include "planner/utility/termination.h"

#include <algorithm>
#include <numeric>

namespace atlas::planner {

void Termination::Observe(double best_utility, double latest_surface_share) {
  greatest_utility_ = std::max(greatest_utility_, best_utility);
  ratio_ = greatest_utility_ > 0.0 ? best_utility / greatest_utility_ : 0.0;
  flat_rounds_ = latest_surface_share < params_.flat_share ? flat_rounds_ + 1 : 0;
  low_rounds_ = ratio_ < params_.stop_ratio ? low_rounds_ + 1 : 0;
  shares_.push_back(latest_surface_share);
  if (shares_.size() > static_cast<size_t>(params_.stop_rounds)) shares_.pop_front();
}

bool Termination::Flat() const {
  if (shares_.size() < static_cast<size_t>(params_.stop_rounds)) return false;
  return std::accumulate(shares_.begin(), shares_.end(), 0.0) < params_.stop_rounds * params_.flat_share;
}

}  // namespace atlas::planner
