// Many runs, one process each: resumable, with an estimate first, a live line, and the table at the end.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "experiments/results/run_summary.h"
#include "experiments/sweep/standing.h"
#include "experiments/sweep/sweep_spec.h"

namespace atlas::experiments {

struct SweepOptions {
  int jobs = 0;                                         ///< runs at a time; 0: as many as cores
  int threads = 1;                                      ///< of each run
  std::filesystem::path out;                            ///< empty: runs/sweep_<name>
  bool slurm = false;                                   ///< write a Slurm array instead of running here
  std::filesystem::path executable = "/proc/self/exe";  ///< what is called as `EXECUTABLE run EXPERIMENT ...`
  std::string command = "./atlas sweep";                ///< what table.md names as its origin
  bool terminal = false;                                ///< the stream rewrites its last line
  /// A run that is to end gets SIGINT, on which it writes its folder; after these, SIGTERM and SIGKILL.
  double interrupt_grace_s = 20.0, terminate_grace_s = 10.0;
  /// Polled ten times a second; true ends the sweep with its folder resumable.
  std::function<bool()> should_stop = [] { return false; };
  bool keep_stale = false;  ///< results of another configuration or commit count as done
  /// Called for each distinct experiment and settings before anything starts. @throws InputError when they
  /// are bad.
  std::function<RunIdentity(const std::string& experiment, const std::vector<std::string>& assignments)>
      identify;
};

/// Runs what the folder does not hold yet, of this configuration and this program, and prints to `out`.
/// Returns 0 when every run is completed or ended on its budget, 1 when some fell, stuck or failed (each is
/// named), 130 when stopped. @throws InputError for bad input, an unwritable folder or a folder in which
/// another sweep runs.
int RunSweep(const SweepSpec& spec, const SweepOptions& options, std::ostream& out);

/// The command of one run. @throws InputError where a word of it holds a control character.
std::vector<std::string> CommandOf(const SweepRun& run, const SweepOptions& options);

/// The runs of a sweep, each with its identity. @throws InputError for bad settings.
std::vector<SweepRun> IdentifiedRuns(const SweepSpec& spec, const SweepOptions& options,
                                     const std::filesystem::path& folder);

/// Summary of a run that need not be run again. @pre run.identity
std::optional<RunSummary> FinishedRun(const SweepRun& run, const SweepOptions& options);

/// Expected wall time of a run: mean of runs of its experiment and settings in the folder, else of its
/// experiment, else the sweep's estimate.
class RunTimeEstimate {
 public:
  RunTimeEstimate(const SweepSpec& spec, const std::vector<SweepRun>& runs);
  double SecondsFor(const SweepRun& run) const;
  bool measured() const { return !walls_.empty(); }

 private:
  struct Wall {
    std::string experiment;
    std::filesystem::path group;
    double seconds;
  };
  double default_s_;
  std::vector<Wall> walls_;
};

}  // namespace atlas::experiments
