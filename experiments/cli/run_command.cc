#include <fmt/format.h>

#include <iostream>

#include "core/files.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/progress_line.h"
#include "experiments/closed_loop.h"
#include "experiments/interrupt.h"
#include "experiments/report/tables.h"

namespace atlas::experiments {
int RunCommand(const RunArguments& arguments) {
  std::vector<std::string> assignments = arguments.assignments;
  if (arguments.video) assignments.emplace_back("output.video=true");
  const ExperimentConfig config = LoadExperiment(arguments.experiment, assignments);

  ProgressLine line;
  RunOptions options;
  options.seed = arguments.seed;
  options.threads = arguments.threads;
  options.folder = arguments.out.empty()
                       ? std::filesystem::path("runs") / config.experiment / std::to_string(arguments.seed)
                       : arguments.out;
  options.should_stop = Interrupted;
  options.progress = [&](const std::string& text, bool final) { line.Show(text, final); };
  InstallInterruptHandler();

  const RunSummary summary = RunClosedLoop(config, options);
  line.Show("", false);
  core::WriteFileAtomically(options.folder / "log.txt", line.log());
  std::cout << CoverageTable(std::vector<RunSummary>{summary});
  std::cout << fmt::format("\n{} ({}); run folder: {}\n", NameOf(summary.status), NameOf(summary.stop_reason),
                           options.folder.string());
  return ExitCodeOf(summary.status);
}

}  // namespace atlas::experiments
