#include "planner/stopping/view_memory.h"

#include <cmath>

namespace atlas::planner {
namespace {

constexpr double kBrokenShare = 0.005;
constexpr double kArrived_m = 0.6;
constexpr double kSamePlace_m = 0.75;

}  // namespace

void ViewMemory::RecordSweep(const core::Pose& T_map_base, size_t new_surface) {
  const core::Vec2 p = T_map_base.translation().head<2>();
  visited_.push_back(p);
  surface_ += static_cast<double>(new_surface);
  latest_share_ = surface_ > 0.0 ? static_cast<double>(new_surface) / surface_ : 0.0;
  if (!commitment_ || (commitment_->p_map - p).norm() > kArrived_m) return;
  if (latest_share_ < kBrokenShare) broken_.push_back(p);
  commitment_.reset();
}

int ViewMemory::BrokenPromisesNear(const core::Vec2& p_map) const {
  int count = 0;
  for (const core::Vec2& q : broken_) count += (p_map - q).norm() < kSamePlace_m ? 1 : 0;
  return count;
}

double ViewMemory::TrustAt(const core::Vec2& p_map, double radius_m) const {
  double trust = 1.0;
  for (const core::Vec2& q : broken_) {
    trust *= 1.0 - std::exp(-(p_map - q).squaredNorm() / (radius_m * radius_m));
  }
  return trust;
}

}  // namespace atlas::planner
