#include "experiments/identity/run_labels.h"

#include <fmt/format.h>

namespace atlas::experiments {

std::string LocalisationLabel(const mapping::LocalisationParams& localisation) {
  if (localisation.name != "truth") return localisation.name;
  return fmt::format("truth, {:g} mm {:g} deg, {:g} s", 1e3 * localisation.sigma_m, localisation.sigma_deg,
                     localisation.period_s);
}

std::string OdometryLabel(const sim::OdometryParams& odometry) {
  if (odometry.name == "truth") return "truth";
  if (odometry.name == "drift") {
    return fmt::format("drift, {:g} x (2 cm 0.1 deg after 2 m), bias {:g}", odometry.drift_scale,
                       odometry.drift_bias);
  }
  if (odometry.name == "lidar") {
    return fmt::format("LiDAR, prior {:g} % {:g} deg/m, {:g} mm {:g} deg after 1 m",
                       100.0 * odometry.prior_bias, odometry.prior_bias_deg_per_m,
                       1e3 * odometry.prior_xy_per_m, odometry.prior_yaw_deg_per_m);
  }
  return fmt::format("random walk, {:g} mm {:g} deg after 1 m; height, roll and pitch true",
                     1e3 * odometry.drift_xy_per_m, odometry.drift_yaw_deg_per_m);
}

std::string TerrainLabel(const sim::LocomotionParams& locomotion) {
  return locomotion.name == "trot" ? locomotion.terrain : "truth";
}

}  // namespace atlas::experiments
