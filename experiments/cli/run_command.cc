#include <fmt/format.h>

#include <iostream>

#include "core/safe_text.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/interrupt.h"
#include "experiments/cli/progress_line.h"
#include "experiments/mission/closed_loop.h"
#include "experiments/report/tables.h"
#include "experiments/results/run_folder.h"

namespace atlas::experiments {
namespace fs = std::filesystem;
namespace {

/// Opens the folder and says where it is when it is not the one to be expected.
fs::path FolderFor(const RunArguments& arguments, const ExperimentConfig& config, core::FolderLock* lock) {
  const bool numbered = arguments.out.empty();
  const fs::path wanted =
      numbered ? fs::path("runs") / config.experiment / std::to_string(config.seed) : arguments.out;
  const fs::path folder = OpenRunFolder({.folder = wanted,
                                         .numbered = numbered,
                                         .force = arguments.force,
                                         .inputs = CheckedInputs(config, arguments.experiment),
                                         .experiment = config.experiment,
                                         .seed = static_cast<uint64_t>(config.seed),
                                         .lock = lock});
  if (folder != wanted) {
    std::cerr << fmt::format("{} holds a run; this one goes to {}\n", wanted.string(), folder.string());
  }
  return folder;
}

}  // namespace

int RunCommand(const RunArguments& arguments) {
  std::vector<std::string> assignments = arguments.assignments;
  if (arguments.video) assignments.emplace_back("output.video=true");
  if (arguments.seed) assignments.push_back(fmt::format("seed={}", *arguments.seed));
  const ExperimentConfig config = LoadExperiment(arguments.experiment, assignments);

  ProgressLine line;
  RunOptions options;
  options.threads = arguments.threads;
  options.should_stop = Interrupted;
  options.progress = [&](const std::string& text, bool final) { line.Show(text, final); };
  options.prepared = StopInOrderOnSignal;
  EndAtOnceOnSignal();
  core::FolderLock lock;
  options.folder = FolderFor(arguments, config, &lock);

  RunSummary summary;
  try {
    summary = RunClosedLoop(config, options);
  } catch (...) {
    DiscardInputs(options.folder);
    throw;
  }
  line.Show("", false);
  std::cout << CoverageTable(GroupRuns({LoadReportedRun(options.folder)}));
  std::cout << fmt::format("\n{} ({}); run folder: {}\n", NameOf(summary.status), NameOf(summary.stop_reason),
                           options.folder.string());
  if (!summary.blocked_at.empty()) std::cout << "blocked_narrow " << summary.blocked_at << "\n";
  return ExitCodeOf(summary.status);
}

}  // namespace atlas::experiments
