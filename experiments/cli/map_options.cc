#include <memory>

#include "experiments/cli/command_line.h"
#include "experiments/cli/map_commands.h"

namespace atlas::experiments {
namespace {

void AddScanOptions(CLI::App* map, MapArguments* a) {
  map->add_option("--scans", a->log.scans,
                  "folder of clouds (PCD, PLY, KITTI .bin), one cloud, OctoMap scan graph, ROS 1 "
                  "FILE.bag[:/topic], "
                  "'DIR/part*.pcd' or a data set of atlas record")
      ->required();
  map->add_option("--poses", a->log.poses,
                  "TUM, KITTI or 4x4 matrix file, or FILE.bag:/topic (default: what lies beside the scans: "
                  "poses.tum, poses.txt, T_A_B.txt; the scan graph's, the bag's)");
  map->add_option("--trajectory", a->log.trajectory,
                  "TUM file at a high rate: a pose for each ray where clouds tell their times");
  map->add_option("--calib", a->log.calibration, "the LiDAR in the frame whose poses were recorded");
  map->add_option(
      "--lidar", a->log.lidar,
      "beams of organised clouds: auto, estimate, none, vlp16, os1_64, os0_64 or Ouster FILE.json");
  map->add_option("--no-return", a->no_return,
                  "points without return: void (free space) or dropout (nothing)")
      ->check(OneOf("points without return", {"void", "dropout"}));
  map->add_option("--max-dt", a->log.max_dt_s, "s: a scan meets poses so near to the time in its name")
      ->check(Between(0.0, 10.0));
  map->add_option("--min-range", a->log.min_range_m, "m: nearer returns carry no information")
      ->check(Between(0.0, 20.0));
  map->add_option("--limit", a->limit, "only the first so many scans (0: all)")->check(Between(0, 100000000));
  map->add_flag("--skip-unreadable", a->skip_unreadable, "go on past clouds that cannot be read");
}

void AddMap(CLI::App* app, int threads, Action* action) {
  const auto a = std::make_shared<MapArguments>();
  a->threads = threads;
  CLI::App* map = app->add_subcommand("map", "Map recorded LiDAR: scans and poses to map.atlas, cloud, mesh");
  AddScanOptions(map, a.get());
  map->add_option("--resolution", a->resolution_m, "m: edge of the smallest voxel")
      ->check(Between(0.005, 2.0));
  map->add_option("--max-range", a->max_range_m, "m: longer returns are free space up to here")
      ->check(Between(1.0, 500.0));
  map->add_option("--field", a->field, "occupancy or tsdf")->check(OneOf("field", {"occupancy", "tsdf"}));
  map->add_option("--local", a->local_radius_m,
                  "m: a rolling map, cropped to this about the LiDAR (0: all is kept)")
      ->check(Between(0.0, 1000.0));
  map->add_flag("--mesh", a->mesh, "write mesh.ply too");
  map->add_option("--set", a->assignments, "mapper.key=value: any parameter of the integrator")->take_all();
  AddOut(map, &a->out, "folder (default runs/map/NAME)");
  AddThreads(map, &a->threads);
  map->callback([=] { *action = [=] { return MapCommand(*a); }; });
}

void AddSlam(CLI::App* app, int threads, Action* action) {
  const auto a = std::make_shared<SlamArguments>();
  a->threads = threads;
  CLI::App* slam = app->add_subcommand(
      "slam", "Map recorded LiDAR without poses: odometry, loops, atlas; writes trajectory, graph, mesh");
  slam->add_option("--scans", a->log.scans,
                   "folder of clouds (PCD, PLY, KITTI .bin), 'DIR/part*.pcd', ROS 1 FILE.bag[:/topic] or a "
                   "data set of atlas record; poses beside them are not read")
      ->required();
  slam->add_option(
      "--odometry", a->odometry,
      "TUM file: the user's own odometry, on which scans are matched (default: from scans alone)");
  slam->add_option("--calib", a->log.calibration, "the LiDAR in the frame of --odometry");
  slam->add_option("--continue", a->earlier,
                   "atlas (or folder that holds it) of an earlier atlas slam: the log is found in it by its "
                   "looks, and goes on in its frame");
  slam->add_option(
      "--lidar", a->log.lidar,
      "beams of organised clouds: auto, estimate, none, vlp16, os1_64, os0_64 or Ouster FILE.json");
  slam->add_option("--no-return", a->no_return,
                   "points without return: void (free space) or dropout (nothing)")
      ->check(OneOf("points without return", {"void", "dropout"}));
  slam->add_option("--max-dt", a->log.max_dt_s, "s: a scan meets odometry so near to its times")
      ->check(Between(0.0, 10.0));
  slam->add_option("--min-range", a->log.min_range_m, "m: nearer returns carry no information")
      ->check(Between(0.0, 20.0));
  slam->add_option("--resolution", a->resolution_m, "m: edge of the smallest voxel")
      ->check(Between(0.005, 2.0));
  slam->add_option("--max-range", a->max_range_m, "m: longer returns are free space up to here")
      ->check(Between(1.0, 500.0));
  slam->add_option("--limit", a->limit, "only the first so many scans (0: all)")
      ->check(Between(0, 100000000));
  slam->add_option("--set", a->assignments, "lidar_odometry.key=value, slam.key=value, mapper.key=value")
      ->take_all();
  AddOut(slam, &a->out, "folder (default runs/slam/NAME)");
  AddThreads(slam, &a->threads);
  slam->callback([=] { *action = [=] { return SlamCommand(*a); }; });
}

void AddMesh(CLI::App* app, int threads, Action* action) {
  const auto a = std::make_shared<MeshArguments>();
  a->threads = threads;
  CLI::App* mesh = app->add_subcommand("mesh", "Surface of a map as a PLY mesh");
  mesh->add_option("map", a->map, "map.atlas, or the folder of an atlas")->required();
  AddOut(mesh, &a->out, "FILE.ply (default: mesh.ply beside the map)");
  mesh->add_option("--min-component", a->min_component_m2,
                   "m2: connected pieces smaller than this are left out")
      ->check(Between(0.0, 1e6));
  AddThreads(mesh, &a->threads);
  mesh->callback([=] { *action = [=] { return MeshCommand(*a); }; });
}

void AddEval(CLI::App* app, int threads, Action* action) {
  const auto a = std::make_shared<EvalArguments>();
  a->threads = threads;
  CLI::App* eval = app->add_subcommand(
      "eval", "Accuracy, completeness and coverage of a map, mesh or cloud, as is and aligned");
  eval->add_option("subject", a->subject, "map.atlas, folder of an atlas, mesh PLY or cloud (PLY, PCD, .bin)")
      ->required();
  eval->add_option("--truth", a->truth, "cloud of the true surface (PLY, PCD, .bin)")->required();
  eval->add_option("--radius", a->radii_m, "m: of coverage; several (default 0.043 0.086)")
      ->check(Between(0.001, 10.0));
  eval->add_option("--points", a->points, "of a map: mesh (samples of its surface) or voxels (their centres)")
      ->check(OneOf("points", {"mesh", "voxels"}));
  eval->add_option("--spacing", a->spacing_m, "m between samples of a mesh")->check(Between(0.001, 1.0));
  eval->add_option("--distance-limit", a->limit_m, "m: longer distances count as this")
      ->check(Between(0.01, 10.0));
  eval->add_option("--json", a->json, "write the numbers here too");
  AddThreads(eval, &a->threads);
  eval->callback([=] { *action = [=] { return EvalCommand(*a); }; });
}

void AddExport(CLI::App* app, Action* action) {
  const auto a = std::make_shared<ExportArguments>();
  CLI::App* command =
      app->add_subcommand("export", "A map as OctoMap .bt or .ot, or its surface voxels as PLY");
  command->add_option("map", a->map, "map.atlas, or the folder of an atlas")->required();
  AddOut(command, &a->out, "FILE.bt, FILE.ot or FILE.ply")->required();
  command->callback([=] { *action = [=] { return ExportCommand(*a); }; });
}

void AddPoseGraph(CLI::App* app, Action* action) {
  const auto a = std::make_shared<PoseGraphArguments>();
  CLI::App* command = app->add_subcommand(
      "posegraph", "Optimises a pose graph from chordal initialisation; costs, time, rejected loops, ATE");
  command->add_option("graph", a->graph, "FILE.g2o (SE2 or SE3:QUAT)")->required();
  command->add_option("--truth", a->truth, "FILE.g2o with the same ids, or poses in the order of ids (TUM)");
  command->add_option("--robust", a->robust, "false loops are found by: none, dcs (fast), gnc (surest)")
      ->check(OneOf("method", {"none", "dcs", "gnc"}));
  command->add_option("--cost", a->cost, "whose minimum --out and --truth take: log, chordal, g2o")
      ->check(OneOf("cost", {"log", "chordal", "g2o"}));
  AddOut(command, &a->out, "FILE.g2o, without the edges rejected (default: none is written)");
  command->callback([=] { *action = [=] { return PoseGraphCommand(*a); }; });
}

}  // namespace

void AddMapCommands(CLI::App* app, int threads, Action* action) {
  AddMap(app, threads, action);
  AddSlam(app, threads, action);
  AddMesh(app, threads, action);
  AddEval(app, threads, action);
  AddExport(app, action);
  AddPoseGraph(app, action);
}

}  // namespace atlas::experiments
