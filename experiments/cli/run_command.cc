#include <fmt/format.h>
#include <unistd.h>

#include <iostream>

#include "core/files.h"
#include "experiments/cli/commands.h"
#include "experiments/closed_loop.h"
#include "experiments/interrupt.h"
#include "experiments/report/tables.h"

namespace atlas::experiments {
namespace {

/// A line that rewrites itself on a terminal; elsewhere only the lines that end a scan.
class ProgressLine {
 public:
  void Show(const std::string& line, bool final) {
    if (terminal_) {
      std::cerr << "\r\033[K" << line << (final ? "\n" : "") << std::flush;
    } else if (final) {
      std::cerr << line << std::endl;
    }
    if (final) log_ += line + "\n";
  }
  const std::string& log() const { return log_; }

 private:
  bool terminal_ = isatty(STDERR_FILENO) == 1;
  std::string log_;
};

}  // namespace

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
