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

void TerminationParams::Visit(core::ParamVisitor& v) {
  v.Field(
      "stop_ratio", &stop_ratio,
      {.min = 0.0,
       .max = 1.0,
       .doc =
           "stop where utility, mean of stop_rounds, falls below this share of the greatest so far (Eq. 3.8, "
           "scale-free)"});
  v.Field("stop_rounds", &stop_rounds,
          {.min = 1, .max = 100, .doc = "latest rounds over which utility must be low and the surface flat"});
  v.Field(
      "flat_share", &flat_share,
      {.min = 0.0, .max = 1.0, .doc = "a sweep that adds less of the surface seen so far counts as flat"});
  v.Field("flat_rounds", &flat_rounds,
          {.min = 1, .max = 100, .doc = "flat sweeps in a row that stop the mission whatever views promise"});
}

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
