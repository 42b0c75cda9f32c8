#include <memory>

#include "core/lidar_model.h"
#include "experiments/cli/command_line.h"
#include "experiments/cli/commands.h"

namespace atlas::experiments {
namespace {

void AddSweep(CLI::App* app, Action* action) {
  const auto a = std::make_shared<SweepArguments>();
  CLI::App* sweep =
      app->add_subcommand("sweep", "Many runs, one process each; resumable; ends with its table");
  sweep->add_option("name", a->name, "name (atlas list sweeps) or FILE.yaml")->required();
  sweep->add_option("--jobs", a->jobs, "runs at a time (0: as many as cores)")->check(Between(0, 1024));
  sweep->add_option("--threads", a->threads, "threads of each run")->check(Between(1, 64));
  AddOut(sweep, &a->out, "folder (default: runs/sweep_NAME)");
  sweep->add_option("--limit", a->limit_s, "s of wall time, then a run is ended (0: limit_s of the sweep)")
      ->check(Between(0.0, 1e7));
  sweep->add_flag("--keep-stale", a->keep_stale, "count results of another configuration or commit as done");
  sweep->add_flag("--slurm", a->slurm, "hand the runs to a Slurm array");
  sweep->callback([=] { *action = [=] { return SweepCommand(*a); }; });
}

void AddReport(CLI::App* app, Action* action) {
  const auto a = std::make_shared<ReportArguments>();
  CLI::App* report =
      app->add_subcommand("report", "Tables, statistics, plots and one HTML page over run folders");
  report->add_option("folders", a->folders, "run folders, or folders of them")->required();
  AddOut(report, &a->out, "where to (default: the first folder)");
  report->callback([=] { *action = [=] { return ReportCommand(*a); }; });
}

void AddBench(CLI::App* app, Action* action) {
  const auto a = std::make_shared<BenchArguments>();
  CLI::App* bench = app->add_subcommand(
      "bench",
      "Measure a part: lidar (rays a second beside bare Embree), mapper (SE-Atlas beside OctoMap), "
      "motion (maps with per-ray poses off and on), correction (from a loop to the corrected map), "
      "odometry (drift of LiDAR odometry), places (precision and recall of loop detection)");
  bench->add_option("what", a->what, "lidar, mapper, motion, correction, odometry or places")->required();
  bench->add_option("--scene", a->scene, "only this scene");
  bench->add_option("--range", a->range_m, "mapper: metres (with --scene)")->check(Between(1.0, 200.0));
  bench->add_option("--resolution", a->resolution_m, "mapper: metres (with --scene)")
      ->check(Between(0.01, 2.0));
  bench->add_option("--scans", a->scans, "mapper, odometry: of the route (0: all)")
      ->check(Between(0, 100000));
  bench->add_option("--threads", a->threads, "of SE-Atlas, of loop checks")->check(Between(1, 64));
  bench->add_option("--simd", a->simd, "mapper: the widest instructions that may be used (default: any)")
      ->check(OneOf("instructions", {"scalar", "sse4", "avx2", "avx512"}));
  bench->add_flag_callback(
      "--no-octomap", [=] { a->octomap = false; }, "mapper: SE-Atlas alone");
  AddOut(bench, &a->out, "tables and plots (default: runs/bench_WHAT)");
  bench->callback([=] { *action = [=] { return BenchCommand(*a); }; });
}

void AddRecord(CLI::App* app, int threads, Action* action) {
  const auto a = std::make_shared<RecordArguments>();
  a->threads = threads;
  CLI::App* record = app->add_subcommand(
      "record", "Carry a LiDAR along a route through a scene; writes a data set for atlas map");
  record->add_option("scene", a->scene, "name (atlas list scenes) or path/scene.yaml")->required();
  record->add_option("--route", a->route, "FILE.yaml (default: the scene's own)");
  record->add_option("--lidar", a->lidar, "atlas list lidars")
      ->check(OneOf("LiDAR model", core::LidarModelNames()));
  AddOut(record, &a->out, "folder (default: runs/record/SCENE)");
  record->add_option("--scans", a->scans, "so many, evenly over the way (default: the route's)")
      ->check(Between(1, 100000));
  record->add_option("--rate", a->rate_hz, "recorded revolutions a second (Hz)");
  record->add_option("--speed", a->speed_m_s, "m/s (default: the route's)")->check(Between(0.01, 30.0));
  record->add_option("--truth-spacing", a->truth_spacing_m, "m between truth points; 0: no truth.ply")
      ->check(Between(0.0, 10.0));
  record->add_option("--seed", a->seed, "seed of the noise")->check(SeedCheck());
  record->add_option("--noise", a->noise, "range noise and dropouts")->check(OneOf("noise", {"on", "off"}));
  AddThreads(record, &a->threads);
  record->callback([=] { *action = [=] { return RecordCommand(*a); }; });
}

}  // namespace

void AddSweepCommands(CLI::App* app, int threads, Action* action) {
  AddSweep(app, action);
  AddReport(app, action);
  AddRecord(app, threads, action);
  AddBench(app, action);
}

}  // namespace atlas::experiments
