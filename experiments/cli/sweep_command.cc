#include <fmt/format.h>
#include <unistd.h>

#include <iostream>

#include "core/cpus.h"
#include "core/files.h"
#include "core/safe_text.h"
#include "experiments/bench/false_loops_sweep.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/interrupt.h"
#include "experiments/cli/progress_line.h"
#include "experiments/identity/experiment_config.h"
#include "experiments/identity/run_identity.h"
#include "experiments/report/report.h"
#include "experiments/sweep/slurm.h"
#include "experiments/sweep/sweep.h"

namespace atlas::experiments {

namespace {

int SweepFalseLoops(const SweepArguments& arguments) {
  const std::filesystem::path folder =
      arguments.out.empty() ? std::filesystem::path("runs") / kFalseLoopSweep : arguments.out;
  core::RemoveStaleTemporaries(folder);
  WriteFalseLoops(folder, {});  // before the work: a bad folder costs nothing
  StopInOrderOnSignal();
  ProgressLine line;
  FalseLoopSweep sweep;
  sweep.threads = arguments.jobs > 0 ? arguments.jobs : core::AvailableCpus();
  const std::vector<FalseLoopOutcome> outcomes = RunFalseLoops(
      sweep, [&](double share) { line.Show(fmt::format("graphs solved: {:3.0f} %", 100.0 * share), false); },
      Interrupted);
  WriteFalseLoops(folder, outcomes);
  line.Show(fmt::format("{} graphs", outcomes.size()), true);
  std::cout << FalseLoopTable(outcomes) << "\ntable: " << folder.string() << "\n";
  return Interrupted() ? 130 : 0;
}

}  // namespace

int SweepCommand(const SweepArguments& arguments) {
  if (arguments.name == kFalseLoopSweep) return SweepFalseLoops(arguments);
  SweepOptions options;
  options.jobs = arguments.jobs;
  options.threads = arguments.threads;
  options.out = arguments.out;
  options.slurm = arguments.slurm;
  options.command = fmt::format("./atlas sweep {}", core::ShellQuoted(arguments.name));
  if (!arguments.out.empty())
    options.command += fmt::format(" --out {}", core::ShellQuoted(arguments.out.string()));
  if (arguments.keep_stale) options.command += " --keep-stale";
  options.terminal = isatty(STDOUT_FILENO) == 1;
  options.should_stop = Interrupted;
  options.keep_stale = arguments.keep_stale;
  options.identify = [](const std::string& experiment, const std::vector<std::string>& assignments) {
    return IdentityOf(LoadExperiment(experiment, assignments));
  };
  SweepSpec spec = LoadSweep(arguments.name);
  if (arguments.limit_s > 0.0) spec.limit_s = arguments.limit_s;
  StopInOrderOnSignal();
  return RunSweep(spec, options, std::cout);
}

int ReportCommand(const ReportArguments& arguments) {
  return RunReport(arguments.folders, arguments.out, std::cout);
}

}  // namespace atlas::experiments
