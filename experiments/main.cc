#include <algorithm>
#include <iostream>

#include "core/cpus.h"
#include "core/safe_text.h"
#include "experiments/cli/command_line.h"
#include "experiments/cli/process.h"
#include "experiments/identity/version.h"

namespace {

using namespace atlas::experiments;

/// Defaults that say nothing are not worth showing: an empty text, path or list.
void HideEmptyDefaults(CLI::App* app) {
  for (CLI::Option* option : app->get_options()) {
    const std::string shown = option->get_default_str();
    if (shown == "\"\"" || shown == "[]" || shown == "{}") option->default_str("");
  }
  for (CLI::App* command : app->get_subcommands({})) HideEmptyDefaults(command);
}

int Main(int argc, char** argv) {
  CLI::App app("SE-Atlas testbed: active mapping with a walking robot in simulation", "atlas");
  app.option_defaults()->always_capture_default();
  app.set_version_flag("--version", VersionText());
  app.require_subcommand(1);
  Action action;
  const int threads = std::min(atlas::core::AvailableCpus(), 64);
  AddRunCommands(&app, threads, &action);
  AddSweepCommands(&app, threads, &action);
  AddMapCommands(&app, threads, &action);
  AddShellCommands(&app, &action);
  app.footer(
      "./atlas test [--sanitize|--tsan] builds and runs the test suite; ./atlas packages prints what is "
      "needed.");
  HideEmptyDefaults(&app);
  if (argc == 1) {
    std::cout << app.help();
    return 0;
  }
  CheckNames(app, argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::cerr << "atlas: " << atlas::core::Printable(error.what()) << "\n";
    return 2;
  }
  return action();
}

}  // namespace

int main(int argc, char** argv) {
  return RunProcess(argc, argv, [&] { return Main(argc, argv); });
}
