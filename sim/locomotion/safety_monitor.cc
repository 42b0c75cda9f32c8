#include "sim/locomotion/safety_monitor.h"

namespace atlas::sim {
namespace {

constexpr double kCollisionN = 5.0;
constexpr double kDebounceS = 0.5;
constexpr double kFallenUpright = 0.3;  ///< cosine of the tilt
constexpr double kFallenHeightM = 0.15;
constexpr double kDropM = 0.25;  ///< below the support plane there is no ground
constexpr double kProbeAboveM = 0.5;

bool OffSolid(const World& world, const GroundPlane& plane, const core::Vec3& p_target) {
  const double z_plane = plane.At(p_target.x(), p_target.y());
  const auto ground = world.GroundBelow({p_target.x(), p_target.y(), z_plane + kProbeAboveM});
  return !ground || *ground < z_plane - kDropM;
}

}  // namespace

bool SafetyMonitor::Episode::Starts(double time_s) {
  const bool starts = time_s - last_s > kDebounceS;
  last_s = time_s;
  return starts;
}

void SafetyMonitor::OnStep(const World& world, const TrotController& controller) {
  const double now = world.time_s();
  const LinkContacts& contacts = world.contacts();
  if (contacts.body_n > kCollisionN && collision_.Starts(now)) ++counts_.collisions;
  if (contacts.shank_n > kCollisionN && brush_.Starts(now)) ++counts_.shank_brushes;

  for (const TrotController::FootNews& news : controller.news()) {
    if (news.event == TrotController::FootEvent::kCommitted) {
      ++counts_.footholds;
      if (OffSolid(world, controller.plane(), news.p_target)) ++counts_.footholds_off_solid;
    } else {
      counts_.worst_foot_drop_m = std::max(counts_.worst_foot_drop_m, news.p_target.z() - news.p_foot.z());
    }
  }

  const core::Pose T_map_base = world.T_map_base();
  const double upright = T_map_base.linear()(2, 2);
  const double height = T_map_base.translation().z() - controller.plane().origin.z();
  const bool down =
      !std::isfinite(height) || upright < kFallenUpright || height < kFallenHeightM || world.Broken();
  if (down && !fallen_) {
    fallen_ = true;
    ++counts_.falls;
  }
}

}  // namespace atlas::sim
