#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <iostream>

#include "core/cpus.h"
#include "core/errors.h"
#include "core/safe_text.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/map_commands.h"
#include "experiments/cli/process.h"

namespace {

using namespace atlas::experiments;
namespace core = atlas::core;
using Action = std::function<int()>;

void AddRun(CLI::App* app, RunArguments* arguments, Action* action) {
  CLI::App* run = app->add_subcommand("run", "Run an experiment: the closed loop, to its coverage table");
  run->add_option("experiment", arguments->experiment, "name (atlas list experiments) or FILE.yaml")
      ->required();
  run->add_option("--seed", arguments->seed, "seed of all randomness");
  run->add_option("--threads", arguments->threads, "threads; results do not depend on it")
      ->check(CLI::Range(1, 64));
  run->add_option("--set", arguments->assignments, "section.key=value, over the file")->take_all();
  run->add_option("--out", arguments->out, "run folder (default runs/EXPERIMENT/SEED, then SEED-2 ...)");
  run->add_flag("--force", arguments->force, "replace the run that the folder holds");
  run->add_flag("--video", arguments->video, "write video.mp4");
  run->callback([=] { *action = [=] { return RunCommand(*arguments); }; });
}

void AddRender(CLI::App* app, RenderArguments* arguments, Action* action) {
  CLI::App* render = app->add_subcommand("render", "Video or picture of a recorded run, or of a scene");
  render->add_option("run", arguments->what, "run folder; with --still also a scene (atlas list scenes)")
      ->required();
  render->add_option("--out", arguments->out,
                     "FILE.mp4, or FILE.png with --still (default in the run folder)");
  render->add_option("--speed", arguments->speed, "times real time")
      ->check(CLI::Range(0.1, 100.0))
      ->capture_default_str();
  render->add_option("--size", arguments->size, "WIDTHxHEIGHT in pixels")->capture_default_str();
  CLI::Option* still = render
                           ->add_option("--still", arguments->still_time_s,
                                        "a picture at this simulated time (s), or at the end")
                           ->expected(0, 1);
  render->add_option("--eye", arguments->eye, "X Y Z (m) of a camera that stays there")->expected(3);
  render->add_option("--target", arguments->target, "X Y Z (m) that it looks at")->expected(3);
  render->callback([=] {
    arguments->still = still->count() > 0;
    *action = [=] { return RenderCommand(*arguments); };
  });
}

struct ListArguments {
  std::string what;
  bool verbose = false;
};

void AddList(CLI::App* app, ListArguments* arguments, Action* action) {
  CLI::App* list =
      app->add_subcommand("list", "List scenes, robots, gains, mappers, planners, experiments, metrics");
  list->add_option("what", arguments->what, "which")->required();
  list->add_flag("--verbose", arguments->verbose, "scenes: exposed area by part");
  list->callback([=] { *action = [=] { return ListCommand(arguments->what, arguments->verbose); }; });
}

void AddExplain(CLI::App* app, RunArguments* arguments, Action* action) {
  CLI::App* explain =
      app->add_subcommand("explain", "Every parameter of an experiment: value, unit, range, meaning");
  explain->add_option("experiment", arguments->experiment, "name or FILE.yaml")->required();
  explain->add_option("--set", arguments->assignments, "section.key=value, over the file")->take_all();
  explain->callback(
      [=] { *action = [=] { return ExplainCommand(arguments->experiment, arguments->assignments); }; });
}

void AddSweep(CLI::App* app, SweepArguments* arguments, Action* action) {
  CLI::App* sweep =
      app->add_subcommand("sweep", "Many runs, one process each; resumable; ends with its table");
  sweep->add_option("name", arguments->name, "table_3_1, table_3_2 or FILE.yaml")->required();
  sweep->add_option("--jobs", arguments->jobs, "runs at a time (default: as many as cores)")
      ->check(CLI::Range(1, 1024));
  sweep->add_option("--threads", arguments->threads, "threads of each run")->check(CLI::Range(1, 64));
  sweep->add_option("--out", arguments->out, "folder (default runs/sweep_NAME)");
  sweep->add_flag("--keep-stale", arguments->keep_stale,
                  "count results of another configuration or commit as done");
  sweep->add_flag("--slurm", arguments->slurm, "hand the runs to a Slurm array");
  sweep->callback([=] { *action = [=] { return SweepCommand(*arguments); }; });
}

void AddReport(CLI::App* app, ReportArguments* arguments, Action* action) {
  CLI::App* report =
      app->add_subcommand("report", "Tables, statistics, plots and one HTML page over run folders");
  report->add_option("folders", arguments->folders, "run folders, or folders of them")->required();
  report->add_option("--out", arguments->out, "where to (default: the first folder)");
  report->callback([=] { *action = [=] { return ReportCommand(*arguments); }; });
}

void AddBench(CLI::App* app, BenchArguments* arguments, Action* action) {
  CLI::App* bench = app->add_subcommand(
      "bench",
      "Measure a part: lidar (rays a second beside bare Embree), mapper (SE-Atlas beside OctoMap), "
      "motion (maps with per-ray poses off and on)");
  bench->add_option("what", arguments->what, "lidar, mapper or motion")->required();
  bench->add_option("--scene", arguments->scene, "only this scene");
  bench->add_option("--range", arguments->range_m, "mapper: metres (with --scene)")
      ->check(CLI::Range(1.0, 200.0));
  bench->add_option("--resolution", arguments->resolution_m, "mapper: metres (with --scene)")
      ->check(CLI::Range(0.01, 2.0));
  bench->add_option("--scans", arguments->scans, "mapper: of the route (default: all)")
      ->check(CLI::Range(1, 100000));
  bench->add_option("--threads", arguments->threads, "of SE-Atlas (default 1)")->check(CLI::Range(1, 64));
  bench->add_option("--simd", arguments->simd, "mapper: scalar, sse4, avx2 or avx512 at most");
  bench->add_flag("!--no-octomap", arguments->octomap, "mapper: SE-Atlas alone");
  bench->add_option("--out", arguments->out, "tables and plots (default runs/bench_WHAT)");
  bench->callback([=] { *action = [=] { return BenchCommand(*arguments); }; });
}

void AddRecord(CLI::App* app, RecordArguments* arguments, Action* action) {
  CLI::App* record = app->add_subcommand(
      "record", "Carry a LiDAR along a route through a scene; writes a data set for atlas map");
  record->add_option("scene", arguments->scene, "name (atlas list scenes) or path/scene.yaml")->required();
  record->add_option("--route", arguments->route, "FILE.yaml (default: the scene's own)");
  record->add_option("--lidar", arguments->lidar, "vlp16, os1_64 or os0_64")->capture_default_str();
  record->add_option("--out", arguments->out, "folder (default runs/record/SCENE)");
  record->add_option("--scans", arguments->scans, "so many, evenly over the way (default: the route's)")
      ->check(CLI::Range(1, 100000));
  record->add_option("--rate", arguments->rate_hz, "recorded revolutions a second (Hz)");
  record->add_option("--speed", arguments->speed_m_s, "m/s (default: the route's)")
      ->check(CLI::Range(0.01, 30.0));
  record->add_option("--truth-spacing", arguments->truth_spacing_m, "m between truth points; 0: no truth.ply")
      ->check(CLI::Range(0.0, 10.0));
  record->add_option("--seed", arguments->seed, "seed of the noise");
  record->add_option("--noise", arguments->noise, "on or off: range noise and dropouts")
      ->capture_default_str();
  record->add_option("--threads", arguments->threads, "threads; results do not depend on it")
      ->check(CLI::Range(1, 64));
  record->callback([=] { *action = [=] { return RecordCommand(*arguments); }; });
}

/// @throws InputError naming the command that is near.
void CheckCommand(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  if (std::find(names.begin(), names.end(), argv[1]) != names.end()) return;
  throw core::InputError(core::UnknownName("command", argv[1], names));
}

int Main(int argc, char** argv) {
  CLI::App app("SE-Atlas testbed: active mapping with a walking robot in simulation", "atlas");
  app.require_subcommand(1);
  Action action;
  RunArguments run;
  run.threads = core::AvailableCpus();
  ListArguments list;
  AddRun(&app, &run, &action);
  RenderArguments render;
  AddRender(&app, &render, &action);
  AddList(&app, &list, &action);
  AddExplain(&app, &run, &action);
  SweepArguments sweep;
  AddSweep(&app, &sweep, &action);
  ReportArguments report;
  AddReport(&app, &report, &action);
  RecordArguments record;
  record.threads = run.threads;
  AddRecord(&app, &record, &action);
  AddMapCommands(&app, run.threads, &action);
  BenchArguments bench;
  AddBench(&app, &bench, &action);
  CheckCommand(app, argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::cerr << "atlas: " << core::Printable(error.what()) << "\n";
    return 2;
  }
  return action();
}

}  // namespace

int main(int argc, char** argv) {
  return atlas::experiments::RunProcess(argc, argv, [&] { return Main(argc, argv); });
}
