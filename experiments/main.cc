#include <CLI/CLI.hpp>
#include <exception>
#include <functional>
#include <iostream>
#include <thread>

#include "core/errors.h"
#include "experiments/cli/commands.h"

namespace {

using namespace atlas::experiments;
using Action = std::function<int()>;

void AddRun(CLI::App* app, RunArguments* arguments, Action* action) {
  CLI::App* run = app->add_subcommand("run", "Run an experiment: the closed loop, to its coverage table");
  run->add_option("experiment", arguments->experiment, "name (atlas list experiments) or FILE.yaml")
      ->required();
  run->add_option("--seed", arguments->seed, "seed of all randomness");
  run->add_option("--threads", arguments->threads, "threads; results do not depend on it")
      ->check(CLI::Range(1, 64));
  run->add_option("--set", arguments->assignments, "section.key=value, over the file")->take_all();
  run->add_option("--out", arguments->out, "run folder (default runs/EXPERIMENT/SEED)");
  run->add_flag("--video", arguments->video, "write video.mp4");
  run->callback([=] { *action = [=] { return RunCommand(*arguments); }; });
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

struct BenchArguments {
  std::string what, scene;
};

void AddBench(CLI::App* app, BenchArguments* arguments, Action* action) {
  CLI::App* bench = app->add_subcommand("bench", "Measure a part: lidar (rays a second beside bare Embree)");
  bench->add_option("what", arguments->what, "lidar")->required();
  bench->add_option("--scene", arguments->scene, "only this scene");
  bench->callback([=] { *action = [=] { return BenchCommand(arguments->what, arguments->scene); }; });
}

int Main(int argc, char** argv) {
  CLI::App app("SE-Atlas testbed: active mapping with a walking robot in simulation", "atlas");
  app.require_subcommand(1);
  Action action;
  RunArguments run;
  run.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  ListArguments list;
  AddRun(&app, &run, &action);
  AddList(&app, &list, &action);
  AddExplain(&app, &run, &action);
  BenchArguments bench;
  AddBench(&app, &bench, &action);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::cerr << "atlas: " << error.what() << "\n";
    return 2;
  }
  return action();
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return Main(argc, argv);
  } catch (const atlas::core::InputError& error) {
    std::cerr << "\natlas: " << error.what() << "\n";
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "\natlas: internal error: " << error.what() << "\n";
    return 1;
  }
}
