#include "core/lidar_model.h"
#include "sim/simulator.h"

namespace atlas::sim {

void LocomotionParams::Visit(core::ParamVisitor& v) {
  v.Field(
      "name", &name,
      {.choices = {"trot", "kinematic", "rail", "carried"},
       .doc = "trot walks under physics; kinematic moves the base without; rail besides keeps it on its path "
              "by its true pose, whatever it believes; carried is a LiDAR without a robot on a route"});
  core::AbsentFields absent(&v, "locomotion.name = " + name);
  core::ParamVisitor &none = absent, &carried = name == "carried" ? v : none;
  carried.Field("route", &route,
                {.doc = "a route of scenes/routes with its speed and sway; empty: the scene's own"});
  v.Field("terrain", &terrain,
          {.choices = {"perceived", "truth"},
           .doc = "what footholds are chosen on: the elevation map or true heights"});
  v.Field("speed_mps", &speed_mps,
          {.unit = "m/s", .min = 0.1, .max = 1.0, .doc = "speed along straight paths"});
  v.Field("sweep_roll_deg", &sweep_roll_deg,
          {.unit = "deg", .min = 0.0, .max = 45.0, .doc = "largest roll of the base in the scanning action"});
  v.Field("sweep_period_s", &sweep_period_s,
          {.unit = "s", .min = 3.0, .max = 60.0, .doc = "one scanning action: to +roll, to -roll and back"});
}

void OdometryParams::Visit(core::ParamVisitor& v) {
  v.Field("name", &name,
          {.choices = {"truth", "legs", "drift", "lidar"},
           .doc = "truth: no error; legs: legs and IMU, roll, pitch and height right; drift: all six wander; "
                  "lidar: scans matched to those before, from legs and IMU with the errors prior_*"});
  core::AbsentFields absent(&v, "odometry.name = " + name);
  core::ParamVisitor &none = absent, &legs = name == "legs" ? v : none, &wander = name == "drift" ? v : none,
                     &prior = name == "lidar" ? v : none;
  wander.Field(
      "drift_scale", &drift_scale,
      {.min = 0.0,
       .max = 10.0,
       .doc = "times 2 cm and 0.1 degrees (standard deviation, an axis) every 2 m: 1 m after 100 m"});
  wander.Field("drift_bias", &drift_bias,
               {.min = 0.0, .max = 2.0, .doc = "an error of one direction besides, as a share of those"});
  legs.Field("drift_xy_per_m", &drift_xy_per_m,
             {.unit = "m",
              .min = 0.0,
              .max = 0.2,
              .doc = "position drift after one metre (standard deviation; random walk)"});
  legs.Field("drift_yaw_deg_per_m", &drift_yaw_deg_per_m,
             {.unit = "deg",
              .min = 0.0,
              .max = 5.0,
              .doc = "heading drift after one metre (standard deviation; random walk)"});
  prior.Field("prior_bias", &prior_bias,
              {.min = -0.2, .max = 0.2, .doc = "legs tell each way as longer by this share"});
  prior.Field("prior_bias_deg_per_m", &prior_bias_deg_per_m,
              {.unit = "deg", .min = -5.0, .max = 5.0, .doc = "and turn by so much a metre"});
  prior.Field("prior_xy_per_m", &prior_xy_per_m,
              {.unit = "m",
               .min = 0.0,
               .max = 0.2,
               .doc = "position error beside, after one metre (standard deviation; random walk)"});
  prior.Field("prior_yaw_deg_per_m", &prior_yaw_deg_per_m,
              {.unit = "deg",
               .min = 0.0,
               .max = 5.0,
               .doc = "heading error beside, after one metre (standard deviation; random walk)"});
  v.Field(
      "velocity_sigma_mps", &velocity_sigma_mps,
      {.unit = "m/s", .min = 0.0, .max = 0.2, .doc = "noise on the base velocity that the gait balances on"});
  v.Field("attitude_sigma_deg", &attitude_sigma_deg,
          {.unit = "deg", .min = 0.0, .max = 3.0, .doc = "noise on the attitude that the gait balances on"});
}

void SensorParams::Visit(core::ParamVisitor& v) {
  std::vector<std::string> lidars = {"robot"};
  for (const std::string& model : core::LidarModelNames()) lidars.push_back(model);
  v.Field("lidar", &lidar, {.choices = lidars, .doc = "LiDAR model; robot: the one the robot carries"});
  v.Field("range_sigma_m", &range_sigma_m,
          {.unit = "m",
           .min = -1.0,
           .max = 0.5,
           .doc = "standard deviation of the LiDAR's range noise; below 0: the model's own"});
  v.Field("walking_spin_stride", &walking_spin_stride,
          {.min = 1, .max = 20, .doc = "while walking or standing every n-th revolution is cast"});
  v.Field("depth_camera", &depth_camera, {.doc = "render the front depth camera while walking"});
  v.Field("depth_width", &depth_width, {.unit = "px", .min = 16, .max = 1280, .doc = "depth image width"});
  v.Field("depth_height", &depth_height, {.unit = "px", .min = 12, .max = 720, .doc = "depth image height"});
  v.Field("depth_rate_hz", &depth_rate_hz,
          {.unit = "Hz", .min = 0.1, .max = 30.0, .doc = "depth images a second"});
  v.Field("depth_max_m", &depth_max_m,
          {.unit = "m", .min = 0.5, .max = 20.0, .doc = "longest depth that is measured"});
}

}  // namespace atlas::sim
