// Every parameter of the simulator, the mapper (in a mission and of `atlas map`) and the elevation map does
// something: changed alone, it changes what that part tells. A mission builds each of them from its section
// as it is here (ExplainedParameters.EverySectionReachesTheMission).
#include <gtest/gtest.h>

#include "experiments/mapping_tools/offline_map.h"
#include "mapping/backends/catalog.h"
#include "mapping/terrain/elevation_map.h"
#include "scenes/catalog.h"
#include "sim/simulator.h"
#include "tests/support/explained_rows.h"
#include "tests/support/moved_keyframes.h"
#include "tests/support/placed_spins.h"
#include "tests/support/terrain_scenes.h"
#include "tests/support/tiny_mission.h"

namespace atlas::experiments {
namespace {

using core::Pose;
using core::Vec2;
using core::Vec3;
using tests::Digest;
using tests::ParameterProbe;
using tests::Settings;

constexpr double kStance_m = 0.44;
const core::Box3 kBlockBox{Vec3(-0.4, -0.4, 0.05), Vec3(0.4, 0.4, 1.0)};

ParameterProbe ProbeOf(const tests::TinyMissions& missions, ParameterProbe::Look look) {
  return {[&missions](const std::vector<std::string>& set) { return missions.LoadBare(set); },
          std::move(look)};
}

/// All that the simulator tells whoever listens, among them the localiser.
class Listener : public core::SensorSink {
 public:
  Listener(sim::Simulator* simulator, mapping::Localiser* localiser)
      : simulator_(*simulator), localiser_(*localiser) {
    simulator->SetSink(this);
  }
  void OnState(const core::StateEvent& event) override {
    localiser_.OnState(event);
    simulator_.SetLocalisation(localiser_.T_map_odom());
    told.Add(event.time_s);
    told.Add(event.T_odom_base);
    told.Add(localiser_.T_map_odom());
  }
  void OnSpin(const std::shared_ptr<const core::SpinEvent>& spin) override {
    told.Add(spin->scan.range_m);
    told.Add(spin->scan.kind);
    for (const core::StampedPose& pose : spin->T_odom_lidar.poses()) told.Add(pose.T);
  }
  void OnDepth(const core::DepthEvent& event) override { told.Add(event.image.depth_m); }
  Digest told;

 private:
  sim::Simulator& simulator_;
  mapping::Localiser& localiser_;
};

/// Ground that the robot believes to be uneven.
class Hummocks : public core::TerrainView {
 public:
  Ground At(double x_map, double y_map) const override {
    return {
        .height_m = 0.01 * std::sin(9.0 * x_map) * std::cos(7.0 * y_map), .known = true, .steppable = true};
  }
};

/// A short walk and a scanning action.
std::string SimulatorTells(const ExperimentConfig& config) {
  const scenes::SceneSpec scene = scenes::LoadScene(config.scene.name);
  const auto simulator =
      sim::MakeSimulator(scene, robots::LoadRobot(config.robot.name), config.sim, core::Rng(3));
  const auto localiser =
      mapping::MakeLocaliser(config.localisation,
                             {.T_map_odom = scene.T_map_spawn,
                              .T_odom_base = simulator->T_odom_base(),
                              .T_map_base_true = [&simulator] { return simulator->TrueBasePose(); }},
                             core::Rng(4));
  Listener listener(simulator.get(), localiser.get());
  const Hummocks ground;
  simulator->Walk({{Vec2(-1.8, 0.0), Vec2(-1.5, 0.1)}, 0.3}, &ground);
  simulator->RollSweep();
  listener.told.Add(simulator->TrueBasePose());
  return listener.told.text();
}

TEST(ExplainedParts, OfTheSimulatorAndTheLocaliserAct) {
  const std::vector<std::string> trot = {"locomotion.name=trot", "locomotion.speed_mps=0.5"},
                                 camera = {"sensors.depth_camera=true"};
  const Settings settings = {
      {"locomotion.terrain", {trot}},           {"locomotion.speed_mps", {{}, "0.5"}},
      {"odometry.velocity_sigma_mps", {trot}},  {"odometry.attitude_sigma_deg", {trot}},
      {"sensors.lidar", {{}, "os1_64"}},        {"sensors.depth_width", {camera}},
      {"sensors.depth_height", {camera}},       {"sensors.depth_rate_hz", {camera}},
      {"sensors.depth_max_m", {camera, "0.6"}},
  };
  const tests::TinyMissions missions;
  ParameterProbe probe = ProbeOf(missions, SimulatorTells);
  for (const auto& context : {trot, camera}) probe.SeeNothingElseAct(context);
  for (const char* section : {"locomotion", "odometry", "localisation", "sensors"}) {
    probe.SeeThemAct(section, {}, settings);
  }
}

/// Sweeps of a block on a floor that ends nearby, from three places.
std::vector<tests::PlacedSpins> SweepsOfABlock() {
  struct Collector : core::SensorSink {
    void OnSpin(const std::shared_ptr<const core::SpinEvent>& spin) override { sweep.spins.push_back(*spin); }
    tests::PlacedSpins sweep;
  };
  tests::PatchWorld world;
  world.AddRectangle(-6, -3, 3, 3, 0);
  world.AddBox({-0.3, -0.3, 0}, {0.3, 0.3, 0.9});
  world.AddBox({-0.4, 0.35, 0.3}, {0.0, 0.38, 0.6});
  tests::TerrainSensors sensors(&world, 1);
  std::vector<tests::PlacedSpins> sweeps;
  for (const Vec3& stand :
       {Vec3(-1.8, 0.0, kStance_m), Vec3(-1.1, 1.2, kStance_m), Vec3(-5.2, 0.0, kStance_m)}) {
    Collector collector;
    sensors.Sweep(core::PoseFromXyzYaw(stand, 0.4), core::Radians(40), 8, &collector);
    sweeps.push_back(collector.sweep);
  }
  return sweeps;
}

/// The sweeps, a keyframe each, and once more from a hand's breadth away, the last of them first taken for a
/// turned place elsewhere.
void Explore(const std::vector<tests::PlacedSpins>& sweeps, mapping::Map* mapper) {
  std::vector<core::Pose> T_map_keyframe;
  for (int lap = 0; lap < 2; ++lap) {
    for (const tests::PlacedSpins& sweep : sweeps)
      T_map_keyframe.push_back(Eigen::Translation3d(0.03 * lap, 0.0, 0.0) * sweep.T_map_odom);
  }
  const auto taken_for = [&](const core::Pose& T_true_taken, uint64_t version) {
    std::vector<core::Pose> T_map_taken = T_map_keyframe;
    T_map_taken.back() = T_map_taken.back() * T_true_taken;
    tests::MovedKeyframes poses(T_map_taken, version);
    poses.sigma_m = 0.1;
    if (version > 0) poses.loops = {{0, 3}};
    return poses;
  };
  const core::Pose away = core::PoseFromXyzYaw(Vec3(1.5, 0.5, 0.0), 0.5);
  for (size_t k = 0; k < T_map_keyframe.size(); ++k) {
    for (const core::SpinEvent& spin : sweeps[k % sweeps.size()].spins)
      mapper->Integrate({.spin = tests::Shared(spin), .keyframe = static_cast<core::KeyframeId>(k)},
                        taken_for(away, 0));
  }
  mapper->Correct(taken_for(away, 1));
  mapper->Correct(taken_for(core::Pose::Identity(), 2));
}

/// The cloud, the file, its memory, and what rays of a planner meet.
std::string MapperTells(const tests::TinyMissions& missions, const std::vector<tests::PlacedSpins>& sweeps,
                        const ExperimentConfig& config) {
  const auto mapper =
      mapping::MakeMap(config.mapper, {.lidar = core::FindLidarModel("vlp16"),
                                       .keep_map = mapping::RegionOf(config.mapper, kBlockBox),
                                       .behind_surface = true});
  Digest told;
  const core::Box3 box = mapping::RegionOf(config.mapper, kBlockBox);
  Explore(sweeps, mapper.get());
  told.Add(static_cast<uint32_t>(mapper->Bytes()));
  for (const tests::PlacedSpins& sweep : sweeps) {
    told.Add(
        tests::CloudOf(sweep, box, config.mapper.integrator.max_range_m, config.mapper.downsample_m).points);
  }
  told.Add(tests::ContentOf(missions.folder() / mapper->Save(missions.folder())));
  const auto view = mapper->Snapshot();
  std::vector<mapping::RaySample> samples;
  for (int i = 0; i < 800; ++i) {  // from the front and from behind
    const double azimuth = -0.35 + 0.035 * (i % 20), elevation = -0.3 + 0.03 * (i / 20 % 20);
    const Vec3 side(i < 400 ? -1.0 : 1.0, 0, 0);
    const Vec3 direction = core::RotationFromYawPitchRoll(azimuth, elevation, 0) * -side;
    told.Add(view->Trace(1.8 * side + Vec3(0, 0.2, 0.7), direction, {.max_range_m = 10.0, .box_map = box},
                         &samples));
    for (const mapping::RaySample& sample : samples) {
      told.Add(sample.occupancy);
      told.Add(sample.behind_surface);
      told.Add(sample.voxels);
    }
  }
  return told.text();
}

const std::string kFine = "mapper.resolution_m=0.03";
/// Where the parameters of the integrator act, in a mission as in `atlas map`.
const Settings kOfTheIntegrator = {
    {"mapper.max_range_m", {{}, "1.5"}},
    {"mapper.void_range_m", {{}, "0.5"}},
    {"mapper.lambda_sigma", {{}, "0.05"}},
    {"mapper.max_scale", {{kFine, "mapper.void_range_m=20"}, "1"}},
    {"mapper.lossless", {{kFine}}},
    {"mapper.remap_stop_rad", {{}, "0.1"}},
    {"mapper.lambda_r", {{kFine, "mapper.behind_max_m=1"}, "0.2"}},
    {"mapper.behind_max_m", {{kFine, "mapper.lambda_r=0.2"}, "0.1"}},
};

TEST(ExplainedParts, OfEveryMapperAct) {
  Settings settings = kOfTheIntegrator;
  settings["mapper.max_scale"] = {{"mapper.resolution_m=0.008"}, "1"};  // the object is near
  settings["mapper.lambda_odom_m"] = {{"mapper.cloud_overlap=0"}, "1"};
  settings["mapper.cloud_overlap"] = {{}, "0"};
  const std::string apart = "mapper.cloud_overlap=1", stay = "mapper.reentry=false";  // a submap a keyframe
  const std::string no_overlap = "mapper.fusion_overlap=0";
  // Two laps leave nothing unmeasured behind the block.
  settings["mapper.behind_surface_m"] = {
      {}, "", "SeAtlasMap.BehindSurfaceIsStoredInUnmeasuredVoxelsBehindWalls"};
  settings["mapper.reentry"] = {{no_overlap}};
  settings["mapper.doorway_m"] = {{}, "", "AtlasDoorways.EachRoomHasASubmapHoweverOftenItIsEntered"};
  settings["mapper.level_m"] = {{}, "", "AtlasFusion.WhatLiesOnAnotherLevelIsNeitherTakenUpNorFused"};
  settings["mapper.reentry_overlap"] = {{}, "", "AtlasDoorways.WhatIsNotTakenUpAgainBeginsAnew"};
  settings["mapper.fusion_overlap"] = {{apart, stay}, "0"};
  settings["mapper.fusion_overlap_both"] = {{apart, stay}, "1"};
  settings["mapper.fusion_range_m"] = {{apart, stay}, "0.01"};
  settings["mapper.lambda_cluster_m"] = {{apart, stay, no_overlap}, "0.01"};
  settings["mapper.sigma_max_m"] = {{apart, stay}, "0.05"};
  settings["mapper.update_m"] = settings["mapper.update_deg"] = {
      {}, "", "AtlasFusion.UnderTheThresholdsOfPoseUpdateNothingIsMeasuredAgain"};
  settings["mapper.memory_limit_mb"] = {{apart, stay, no_overlap}, "0.01"};
  const tests::TinyMissions missions;
  const std::vector<tests::PlacedSpins> sweeps = SweepsOfABlock();
  ParameterProbe probe = ProbeOf(
      missions, [&](const ExperimentConfig& config) { return MapperTells(missions, sweeps, config); });
  for (const mapping::CatalogEntry& mapper : mapping::Catalog()) {
    probe.SeeNothingElseAct({"mapper=" + mapper.name});
    probe.SeeThemAct("mapper", {"mapper=" + mapper.name}, settings);
  }
}

/// What `atlas map --set` sets, and `explain map` prints.
struct MapConfig {
  OfflineMapParams mapper;
  std::vector<core::ParamRow> rows;
  void Visit(core::ParamVisitor& v) { v.Section("mapper", &mapper); }
};

TEST(ExplainedParts, OfTheMapOfARecordingAct) {
  Settings settings = kOfTheIntegrator;
  settings["mapper.local_radius_m"] = {{}, "1"};
  settings["mapper.cloud_spacing_m"] = {{}, "0.2"};
  const tests::TinyMissions missions;
  const std::vector<tests::PlacedSpins> sweeps = SweepsOfABlock();
  const auto load = [](const std::vector<std::string>& set) {
    core::ParamSource source;
    for (const std::string& assignment : set) source.MergeAssignment(assignment);
    MapConfig config;
    config.rows = source.Load(&config);
    return config;
  };
  const auto look = [&](const MapConfig& config) {
    OfflineMapper mapper(config.mapper, core::FindLidarModel("vlp16"));
    for (const tests::PlacedSpins& sweep : sweeps) {
      for (const size_t spin : {2, 5}) mapper.Add(sweep.spins.at(spin), Pose::Identity());
    }
    Digest told;
    told.Add(mapper.Cloud().points);
    const auto file = missions.folder() / "map.atlas";
    std::visit([&](const auto& map) { mapping::WriteMap(file, map); }, mapper.map());
    told.Add(core::ReadFile(file));
    return told.text();
  };
  tests::ProbeOfConfig<MapConfig> probe(load, look);
  for (const std::string field : {"occupancy", "tsdf"}) {
    const std::vector<std::string> small = {"mapper.field=" + field, "mapper.resolution_m=0.1",
                                            "mapper.void_range_m=3"};
    probe.SeeNothingElseAct(small);
    probe.SeeThemAct("mapper", small, settings);
  }
}

/// A floor with all that may stop a robot: steps low and high, ramps gentle and steep, gravel, a pit and an
/// edge, a gap.
tests::PatchWorld RoughGround() {
  tests::PatchWorld world;
  world.AddPlateWithHole(-3, -3, 3, 3, 0, {Vec3(1.0, -0.5, -1), Vec3(2.0, 0.5, 1)});
  world.AddRectangle(1.0, -0.5, 2.0, 0.5, -0.4);
  world.AddBox({-2.5, 1.0, 0}, {-1.5, 2.5, 0.18});
  world.AddBox({1.0, 1.2, 0}, {1.2, 1.4, 0.9});
  world.patches.push_back({{-2.5, -2.5, 0}, {1.0, 0, 0.3}, {0, 1.2, 0}});
  world.patches.push_back({{0.2, -2.8, 0}, {0.8, 0, 0.5}, {0, 1.2, 0}});
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 5; ++j) {
      if ((i + j) % 2 == 0) continue;
      const Vec3 corner(-0.9 + 0.2 * i, 1.2 + 0.2 * j, 0);
      world.AddBox(corner, corner + Vec3(0.2, 0.2, 0.1));
    }
  }
  return world;
}

struct Survey {
  explicit Survey(const tests::PatchWorld& world) {
    struct Collector : core::SensorSink {
      explicit Collector(Survey* s) : survey(s) {}
      void OnState(const core::StateEvent& event) override { survey->states.push_back(event); }
      void OnSpin(const std::shared_ptr<const core::SpinEvent>& spin) override {
        survey->spins.push_back(spin);
      }
      Survey* survey;
    } collector(this);
    tests::TerrainSensors sensors(&world, 1);
    sensors.column_stride = 3;
    for (const double x : {0.0, 0.4}) {
      sensors.Sweep(core::PoseFromXyzYaw(Vec3(x, 0, kStance_m), 0), core::Radians(40), 15, &collector);
    }
  }
  std::vector<core::StateEvent> states;
  std::vector<std::shared_ptr<const core::SpinEvent>> spins;
};

std::string TerrainTells(const Survey& survey, const ExperimentConfig& config) {
  mapping::ElevationMap map(config.planner.terrain, robots::LoadRobot(config.robot.name));
  map.InitialiseUnderRobot(core::PoseFromXyzYaw(Vec3(0, 0, kStance_m), 0));
  for (size_t i = 0; i < survey.spins.size(); ++i) {
    map.OnState(survey.states[i]);
    map.OnSpin(survey.spins[i]);
  }
  map.Update();
  const mapping::ElevationMap::Grid grid = map.Export();
  Digest told;
  told.Add(grid.height_m);
  told.Add(grid.traversability);
  told.Add(grid.kind);
  for (int i = 0; i < 24 * 24 * 4; ++i) {
    const Vec2 p(-3.0 + 0.25 * (i % 24), -3.0 + 0.25 * (i / 24 % 24));
    told.Add(map.FootprintFree(map.OnRobotsLevel(p, 0.0), 0.25 * core::kPi * (i / 576)));
  }
  return told.text();
}

TEST(ExplainedParts, OfTheTerrainAct) {
  const Survey survey(RoughGround());
  const tests::TinyMissions missions;
  ParameterProbe probe =
      ProbeOf(missions, [&](const ExperimentConfig& config) { return TerrainTells(survey, config); });
  probe.SeeNothingElseAct({});
  probe.SeeThemAct("planner.terrain", {}, {{"planner.terrain.window_m", {{}, "4"}}});
}

}  // namespace
}  // namespace atlas::experiments
