#include "sim/locomotion/terrain_sampler.h"

namespace atlas::sim {
namespace {

constexpr double kGroundProbeAboveM = 0.6;  ///< higher surfaces overhang or wall off; they are not ground
constexpr double kPitM = 1.0;               ///< a drop deeper than this carries no foot

}  // namespace

TerrainSampler::Sample TerrainSampler::At(double x, double y) const {
  const double z_plane = plane_.At(x, y);
  switch (source_) {
    case GroundSource::kPerceived:
      return Perceived(x, y, z_plane);
    case GroundSource::kTruth:
      return Truth(x, y, z_plane);
    case GroundSource::kPlane:
      break;
  }
  return {z_plane, false, true};
}

TerrainSampler::Sample TerrainSampler::Perceived(double x, double y, double z_plane) const {
  const core::Vec3 p_odom = T_odom_map_ * core::Vec3(x, y, z_plane);
  const core::TerrainView::Ground ground = view_->At(p_odom.x(), p_odom.y());
  if (!ground.known) return {z_plane, false, false};
  return {z_plane + ground.height_m - p_odom.z(), true, ground.steppable};
}

TerrainSampler::Sample TerrainSampler::Truth(double x, double y, double z_plane) const {
  const double z_probe = z_plane + kGroundProbeAboveM;
  const std::optional<double> z = true_ground_({x, y, z_probe});
  if (!z || *z < z_plane - kPitM) return {z_plane - kPitM, true, false};
  return {*z, true, *z < z_probe};
}

}  // namespace atlas::sim
