#include "planner/stopping/view_memory.h"

#include <cmath>

namespace atlas::planner {
namespace {

using core::Vec2;

constexpr double kBrokenShare = 0.005;
constexpr double kArrived_m = 0.6;
constexpr double kSamePlace_m = 0.75;

}  // namespace

void ViewMemory::RecordSweep(const core::Pose& T_map_base, size_t new_surface,
                             const core::PoseSource& poses) {
  Correct(poses);
  const Vec2 p = T_map_base.translation().head<2>();
  anchors_.push_back(core::AnchoredPoint::At(T_map_base.translation(), poses));
  visited_.push_back(p);
  surface_ += static_cast<double>(new_surface);
  latest_share_ = surface_ > 0.0 ? static_cast<double>(new_surface) / surface_ : 0.0;
  if (!commitment_ || (commitment_->p_map - p).norm() > kArrived_m) return;
  if (latest_share_ < kBrokenShare) broken_.push_back(visited_.size() - 1);
  commitment_.reset();
}

void ViewMemory::Commit(const Promise& promise, const core::PoseSource& poses) {
  Correct(poses);
  commitment_ = promise;
  const core::Pose T_map_view = core::MakePose(core::RotationFromYawPitchRoll(promise.yaw_rad, 0.0, 0.0),
                                               core::Vec3(promise.p_map.x(), promise.p_map.y(), 0.0));
  const core::KeyframeId keyframe = poses.latest();
  commitment_anchor_ = {keyframe, poses.T_map_keyframe(keyframe).inverse() * T_map_view};
}

void ViewMemory::Correct(const core::PoseSource& poses) {
  if (poses.version() == version_) return;
  version_ = poses.version();
  for (size_t i = 0; i < anchors_.size(); ++i) visited_[i] = anchors_[i].p_map(poses).head<2>();
  if (!commitment_) return;
  const core::Pose T_map_view = commitment_anchor_.T_map_here(poses);
  commitment_ = {T_map_view.translation().head<2>(), core::YawOf(T_map_view.linear())};
}

int ViewMemory::BrokenPromisesNear(const Vec2& p_map) const {
  int count = 0;
  for (const size_t i : broken_) count += (p_map - visited_[i]).norm() < kSamePlace_m ? 1 : 0;
  return count;
}

double ViewMemory::TrustAt(const Vec2& p_map, double radius_m) const {
  double trust = 1.0;
  for (const size_t i : broken_) {
    trust *= 1.0 - std::exp(-(p_map - visited_[i]).squaredNorm() / (radius_m * radius_m));
  }
  return trust;
}

}  // namespace atlas::planner
