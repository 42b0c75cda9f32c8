// Runs of a sweep as child processes: so many at a time, each within its time, none left behind.
#pragma once

#include <chrono>
#include <iosfwd>
#include <list>
#include <string>
#include <vector>

#include "experiments/sweep/child_process.h"
#include "experiments/sweep/sweep.h"

namespace atlas::experiments {

/// Of a run folder: the exit code of a process that nobody waited for (Slurm), where it was not 0.
inline constexpr const char* kExitCodeFile = "exit_code";

/// Whether the process that wrote a run folder is known to have ended otherwise than `status` says.
bool EndedOtherwise(const std::filesystem::path& folder, RunStatus status);

/// Of a run folder: what its process printed.
inline constexpr const char* kConsoleLog = "console.log";

/// Makes what a run of the sweep left, its summary lost or damaged, a broken run, which `run --force`
/// replaces. Its log tells it from a folder of the user's. @throws InputError where that cannot be written.
void ClaimLeftovers(const SweepRun& run);

/// "car_greedy/3".
std::string LabelOf(const SweepRun& run);

/// Starts runs, watches them, and reports each as it ends. A run counts only when its process ended as its
/// summary says (ExitCodeOf); any other is failed, and its summary then says so too.
class RunPool {
 public:
  /// @param jobs  runs at a time
  /// @param limit_s  wall time of a run; beyond it, it is ended
  RunPool(const std::vector<SweepRun>& pending, const RunTimeEstimate& estimate, int jobs, double limit_s,
          const SweepOptions& options, std::ostream& out);

  /// False when stopped from outside; then all children have ended.
  bool RunAll();

 private:
  using Clock = std::chrono::steady_clock;
  struct Active {
    const SweepRun* run;
    ChildProcess child;
    Clock::time_point begin;
    int asked = 0;  ///< to end: once by SIGINT, twice by SIGTERM, then SIGKILL
  };

  void Start(const SweepRun& run);
  void AskToEnd(Active* active, double over_s) const;
  void Reap();
  void Report(const Active& active, const ChildExit& end);
  void ShowProgress();
  void ClearLine();
  void EndChildren();

  const std::vector<SweepRun>& pending_;
  const RunTimeEstimate& estimate_;
  size_t jobs_;
  double limit_s_;
  const SweepOptions& options_;
  std::ostream& out_;
  std::list<Active> active_;
  size_t next_ = 0, done_ = 0;
  double done_estimate_s_ = 0.0, done_actual_s_ = 0.0;
};

}  // namespace atlas::experiments
