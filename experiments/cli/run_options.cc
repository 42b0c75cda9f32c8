#include <memory>

#include "experiments/cli/command_line.h"
#include "experiments/cli/commands.h"

namespace atlas::experiments {
namespace {

void AddRun(CLI::App* app, int threads, Action* action) {
  const auto a = std::make_shared<RunArguments>();
  a->threads = threads;
  CLI::App* run = app->add_subcommand("run", "Run an experiment: the closed loop, to its coverage table");
  run->add_option("experiment", a->experiment, "name (atlas list experiments) or FILE.yaml")->required();
  run->add_option("--seed", a->seed, "seed of all randomness, over the file's")
      ->default_str("1")
      ->check(SeedCheck());
  AddThreads(run, &a->threads);
  run->add_option("--set", a->assignments, "section.key=value, over the file")->take_all();
  AddOut(run, &a->out, "run folder (default: runs/EXPERIMENT/SEED, then SEED-2 ...)");
  run->add_flag("--force", a->force, "replace the run that the folder holds");
  run->add_flag("--video", a->video, "write video.mp4");
  run->callback([=] { *action = [=] { return RunCommand(*a); }; });
}

void AddRender(CLI::App* app, Action* action) {
  const auto a = std::make_shared<RenderArguments>();
  CLI::App* render = app->add_subcommand("render", "Video or picture of a recorded run, or of a scene");
  render->add_option("run", a->what, "run folder; with --still also a scene (atlas list scenes)")->required();
  AddOut(render, &a->out, "FILE.mp4, or FILE.png with --still (default: in the run folder)");
  render->add_option("--speed", a->speed, "times real time")->check(Between(0.1, 100.0));
  render->add_option("--size", a->size, "WIDTHxHEIGHT in pixels");
  CLI::Option* still =
      render->add_option("--still", a->still_time_s, "a picture at this simulated time (s), or at the end")
          ->check(Between(0.0, 1e9))
          ->expected(0, 1);
  render->add_flag("--plan", a->plan,
                   "the ground from above: free or why not, way, scans, ways too narrow (FILE.png)");
  render->add_option("--eye", a->eye, "X Y Z (m) of a camera that stays there (default: it finds its place)")
      ->check(Between(-1e6, 1e6))
      ->expected(3);
  render->add_option("--target", a->target, "X Y Z (m) that it looks at")
      ->check(Between(-1e6, 1e6))
      ->expected(3);
  render->callback([=] {
    a->still = still->count() > 0;
    *action = [=] { return RenderCommand(*a); };
  });
}

void AddExplain(CLI::App* app, Action* action) {
  const auto a = std::make_shared<ExplainArguments>();
  CLI::App* explain = app->add_subcommand(
      "explain", "Every parameter of an experiment, or of `map`: value, unit, range, where set, meaning");
  explain->add_option("experiment", a->what, "name, FILE.yaml, or map")->required();
  explain->add_option("prefix", a->prefixes, "only keys that begin so: planner, planner.stop ...");
  explain->add_option("--set", a->assignments, "section.key=value, over the file")->take_all();
  explain->callback([=] { *action = [=] { return ExplainCommand(*a); }; });
}

void AddList(CLI::App* app, Action* action) {
  struct Arguments {
    std::string what;
    bool verbose = false;
  };
  const auto a = std::make_shared<Arguments>();
  CLI::App* list =
      app->add_subcommand("list", "What there is: scenes, gains, sweeps and other kinds of things");
  list->add_option("kind", a->what, "of what (default: the kinds)");
  list->add_flag("--verbose", a->verbose, "scenes: exposed area by part");
  list->callback([=] { *action = [=] { return ListCommand(a->what, a->verbose); }; });
}

void AddCheck(CLI::App* app, Action* action) {
  const auto a = std::make_shared<CheckArguments>();
  CLI::App* check = app->add_subcommand("check", "Is a scene sound, and its ground truth on its meshes?");
  check->add_option("scene", a->scene, "name (atlas list scenes) or path/scene.yaml")->required();
  check->add_flag("--truth", a->truth, "lay its ground truth: distances to the mesh, completeness, areas");
  check->callback([=] { *action = [=] { return CheckSceneCommand(*a); }; });
}

}  // namespace

void AddRunCommands(CLI::App* app, int threads, Action* action) {
  AddRun(app, threads, action);
  AddRender(app, action);
  AddExplain(app, action);
  AddList(app, action);
  AddCheck(app, action);
}

}  // namespace atlas::experiments
