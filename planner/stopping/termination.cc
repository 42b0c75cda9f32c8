#include "planner/stopping/termination.h"

#include <algorithm>
#include <numeric>

namespace atlas::planner {

namespace {

void Keep(double value, int count, std::deque<double>* latest) {
  latest->push_back(value);
  if (latest->size() > static_cast<size_t>(count)) latest->pop_front();
}

bool MeanBelow(const std::deque<double>& latest, int count, double limit) {
  return latest.size() == static_cast<size_t>(count) &&
         std::accumulate(latest.begin(), latest.end(), 0.0) < count * limit;
}

}  // namespace

void Termination::Observe(double best_utility, double latest_surface_share) {
  greatest_utility_ = std::max(greatest_utility_, best_utility);
  ratio_ = greatest_utility_ > 0.0 ? best_utility / greatest_utility_ : 0.0;
  const bool flat = !NothingWasPromised() && latest_surface_share < params_.flat_share;
  flat_rounds_ = flat ? flat_rounds_ + 1 : 0;
  Keep(ratio_, params_.stop_rounds, &ratios_);
  Keep(latest_surface_share, params_.stop_rounds, &shares_);
}

bool Termination::Low() const {
  return MeanBelow(ratios_, params_.stop_rounds, params_.stop_ratio);
}

bool Termination::Flat() const {
  return MeanBelow(shares_, params_.stop_rounds, params_.flat_share);
}

}  // namespace atlas::planner
