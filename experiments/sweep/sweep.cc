#include "experiments/sweep/sweep.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/file.h>
#include <unistd.h>

#include <chrono>
#include <list>
#include <map>
#include <ostream>
#include <thread>

#include "core/errors.h"
#include "core/files.h"
#include "experiments/report/mapper_pairs.h"
#include "experiments/report/tables.h"
#include "experiments/sweep/child_process.h"
#include "experiments/sweep/slurm.h"

namespace atlas::experiments {
namespace fs = std::filesystem;
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kPollEvery = std::chrono::milliseconds(100);
constexpr double kInterruptGraceS = 20.0;  // a run writes its folder on SIGINT; then SIGTERM, then SIGKILL
constexpr double kTerminateGraceS = 10.0;

double SecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// Held while a sweep runs in a folder, so that two cannot mix their runs.
class FolderLock {
 public:
  explicit FolderLock(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    const fs::path path = folder / ".lock";
    file_ = open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
    if (file_ < 0) throw core::InputError(folder.string() + ": cannot write there");
    if (flock(file_, LOCK_EX | LOCK_NB) != 0) {
      close(file_);
      throw core::InputError(folder.string() + ": another sweep is running there");
    }
  }
  ~FolderLock() { close(file_); }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_ = -1;
};

std::string LabelOf(const SweepRun& run) {
  return (run.folder.parent_path().filename() / run.folder.filename()).string();
}

std::string LastLine(const fs::path& log) {
  std::string text;
  try {
    text = core::ReadFile(log);
  } catch (const core::InputError&) {
    return "no output";
  }
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  const size_t begin = text.find_last_of("\r\n");
  return text.substr(begin == std::string::npos ? 0 : begin + 1);
}

/// Starts runs, watches them, and reports each as it ends.
class Pool {
 public:
  Pool(const std::vector<SweepRun>& pending, const RunTimeEstimate& estimate, int jobs,
       const SweepOptions& options, std::ostream& out)
      : pending_(pending),
        estimate_(estimate),
        jobs_(static_cast<size_t>(jobs)),
        options_(options),
        out_(out) {}

  /// False when stopped from outside.
  bool RunAll() {
    while (next_ < pending_.size() || !active_.empty()) {
      if (options_.should_stop()) {
        EndChildren();
        return false;
      }
      while (active_.size() < jobs_ && next_ < pending_.size()) Start(pending_[next_++]);
      std::this_thread::sleep_for(kPollEvery);
      Reap();
      ShowProgress();
    }
    ClearLine();
    return true;
  }

 private:
  struct Active {
    const SweepRun* run;
    ChildProcess child;
    Clock::time_point begin;
  };

  void Start(const SweepRun& run) {
    // What an earlier attempt left must not be taken for this one's result.
    std::error_code error;
    fs::remove(run.folder / "summary.json", error);
    fs::create_directories(run.folder, error);
    active_.push_back(
        {&run, ChildProcess(CommandOf(run, options_), run.folder / "console.log"), Clock::now()});
  }

  void Reap() {
    for (auto active = active_.begin(); active != active_.end();) {
      const std::optional<ChildExit> end = active->child.Poll();
      if (!end) {
        ++active;
        continue;
      }
      Report(*active, *end);
      done_estimate_s_ += estimate_.SecondsFor(*active->run);
      done_actual_s_ += SecondsSince(active->begin);
      ++done_;
      active = active_.erase(active);
    }
  }

  void Report(const Active& active, const ChildExit& end) {
    ClearLine();
    const std::string head =
        fmt::format("[{:{}}/{}] {:<48}", done_ + 1, std::to_string(pending_.size()).size(), pending_.size(),
                    LabelOf(*active.run));
    if (const auto summary = FinishedRun(*active.run, options_)) {
      out_ << fmt::format("{} {:<10} c_p {:6.2f} %  {:5.1f} m  {:2.0f} scans  {}\n", head,
                          NameOf(summary->status), 100.0 * summary->coverage.value_or(0.0),
                          summary->travel_distance_m.value_or(0.0), summary->scans.value_or(0.0),
                          MinutesSeconds(SecondsSince(active.begin)));
    } else {
      out_ << fmt::format("{} FAILED ({} {}): {}\n", head, end.by_signal ? "signal" : "exit code",
                          end.by_signal ? end.code - 128 : end.code,
                          LastLine(active.run->folder / "console.log"));
    }
    out_.flush();
  }

  void ShowProgress() {
    if (!options_.terminal) return;
    double remaining_s = 0.0;
    for (size_t i = next_; i < pending_.size(); ++i) remaining_s += estimate_.SecondsFor(pending_[i]);
    for (const Active& a : active_) {
      remaining_s += std::max(0.0, estimate_.SecondsFor(*a.run) - SecondsSince(a.begin));
    }
    const double pace = done_estimate_s_ > 0.0 ? done_actual_s_ / done_estimate_s_ : 1.0;
    out_ << fmt::format("\r\033[K{} of {} done, {} running, about {} left", done_, pending_.size(),
                        active_.size(), MinutesSeconds(pace * remaining_s / static_cast<double>(jobs_)));
    out_.flush();
  }
  void ClearLine() {
    if (options_.terminal) out_ << "\r\033[K" << std::flush;
  }

  void EndChildren() {
    ClearLine();
    out_ << fmt::format("stopping {} runs ...\n", active_.size()) << std::flush;
    const auto wait = [&](double limit_s) {
      const Clock::time_point begin = Clock::now();
      while (!active_.empty() && SecondsSince(begin) < limit_s) {
        std::this_thread::sleep_for(kPollEvery);
        active_.remove_if([](Active& a) { return a.child.Poll().has_value(); });
      }
    };
    for (const Active& a : active_) a.child.Signal(SIGINT);
    wait(kInterruptGraceS);
    for (const Active& a : active_) a.child.Signal(SIGTERM);
    wait(kTerminateGraceS);
    active_.clear();  // SIGKILL for what is left
  }

  const std::vector<SweepRun>& pending_;
  const RunTimeEstimate& estimate_;
  size_t jobs_;
  const SweepOptions& options_;
  std::ostream& out_;
  std::list<Active> active_;
  size_t next_ = 0, done_ = 0;
  double done_estimate_s_ = 0.0, done_actual_s_ = 0.0;
};

/// Of the finished runs, what tables take.
std::vector<ReportedRun> LoadFinished(const std::vector<SweepRun>& runs, const SweepOptions& options) {
  std::vector<ReportedRun> finished;
  for (const SweepRun& run : runs) {
    if (!FinishedRun(run, options)) continue;
    finished.push_back(LoadReportedRun(run.folder));
    try {
      finished.back().curve = LoadCoverageCurve(run.folder);
    } catch (const core::InputError&) {
      continue;  // a damaged curve costs its pair, not the table
    }
  }
  return finished;
}

/// The tables, their files, and what did not end well. Returns the exit code.
int Conclude(const std::vector<SweepRun>& runs, const SweepOptions& options, const fs::path& folder,
             std::ostream& out) {
  std::vector<std::string> bad;
  for (const SweepRun& run : runs) {
    const auto summary = FinishedRun(run, options);
    if (!summary) {
      const std::string why = StandingOf(run).why;
      bad.push_back(fmt::format("{}: no result{} ({})", LabelOf(run), why.empty() ? "" : ", " + why,
                                (run.folder / "console.log").string()));
    } else if (ExitCodeOf(summary->status) != 0) {
      bad.push_back(
          fmt::format("{}: {} ({})", LabelOf(run), NameOf(summary->status), NameOf(summary->stop_reason)));
    }
  }
  const GroupedRuns grouped = GroupRuns(LoadFinished(runs, options));
  WriteTables(grouped, options.command, folder);
  if (!grouped.groups.empty()) out << "\n" << CoverageTable(grouped);
  const TextTable pairs = MapperPairsTable(grouped.groups);
  if (!pairs.rows.empty()) out << "\n" << ToTerminal(pairs);
  if (!bad.empty()) out << fmt::format("\n{} of {} runs did not end well:\n", bad.size(), runs.size());
  for (const std::string& line : bad) out << "  " << line << "\n";
  out << fmt::format("\ntables: {}\n",
                     (folder / "table.{md,csv,tex}").string() + (pairs.rows.empty() ? "" : ", pairs.md"));
  return bad.empty() ? 0 : 1;
}

}  // namespace

std::vector<std::string> CommandOf(const SweepRun& run, const SweepOptions& options) {
  std::vector<std::string> command = {options.executable.string(),
                                      "run",
                                      run.experiment,
                                      "--seed",
                                      std::to_string(run.seed),
                                      "--threads",
                                      std::to_string(options.threads),
                                      "--force",  // stale and broken runs are replaced
                                      "--out",
                                      run.folder.string()};
  for (const std::string& assignment : run.assignments) {
    command.push_back("--set");
    command.push_back(assignment);
  }
  return command;
}

std::vector<SweepRun> IdentifiedRuns(const SweepSpec& spec, const SweepOptions& options,
                                     const fs::path& folder) {
  std::vector<SweepRun> runs = ExpandSweep(spec, folder);
  std::map<fs::path, std::shared_ptr<const RunIdentity>> known;  // seeds share one
  for (SweepRun& run : runs) {
    std::shared_ptr<const RunIdentity>& identity = known[run.folder.parent_path()];
    if (!identity) {
      identity = std::make_shared<const RunIdentity>(options.identify(run.experiment, run.assignments));
    }
    run.identity = identity;
  }
  return runs;
}

std::optional<RunSummary> FinishedRun(const SweepRun& run, const SweepOptions& options) {
  RunStanding standing = StandingOf(run);
  const bool counts =
      standing.state == RunState::kDone || (standing.state == RunState::kStale && options.keep_stale);
  return counts ? std::move(standing.summary) : std::nullopt;
}

RunTimeEstimate::RunTimeEstimate(const SweepSpec& spec, const std::vector<SweepRun>& runs)
    : default_s_(spec.estimate_s) {
  for (const SweepRun& run : runs) {
    const auto summary = StandingOf(run).summary;
    if (summary && summary->wall_time_s) {
      walls_.push_back({run.experiment, run.folder.parent_path(), *summary->wall_time_s});
    }
  }
}

double RunTimeEstimate::SecondsFor(const SweepRun& run) const {
  double group_s = 0.0, experiment_s = 0.0;
  int group = 0, experiment = 0;
  for (const Wall& wall : walls_) {
    if (wall.experiment != run.experiment) continue;
    experiment_s += wall.seconds;
    ++experiment;
    if (wall.group != run.folder.parent_path()) continue;
    group_s += wall.seconds;
    ++group;
  }
  if (group > 0) return group_s / group;
  return experiment > 0 ? experiment_s / experiment : default_s_;
}

int RunSweep(const SweepSpec& spec, const SweepOptions& options, std::ostream& out) {
  const fs::path folder = options.out.empty() ? fs::path("runs") / ("sweep_" + spec.name) : options.out;
  const std::vector<SweepRun> runs = IdentifiedRuns(spec, options, folder);
  const FolderLock lock(folder);

  std::vector<SweepRun> pending;
  std::vector<RunStanding> standings;
  for (const SweepRun& run : runs) {
    standings.push_back(StandingOf(run));
    if (!FinishedRun(run, options)) pending.push_back(run);
  }
  if (options.slurm) return SubmitToSlurm(spec, pending, options, folder, out);

  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const int jobs = std::max(1, options.jobs > 0 ? options.jobs : cores / std::max(1, options.threads));
  const RunTimeEstimate estimate(spec, runs);
  double total_s = 0.0;
  for (const SweepRun& run : pending) total_s += estimate.SecondsFor(run);
  out << fmt::format("sweep {}: {} runs: {}{}; {} to run, {} at a time; estimated time {} ({})\n", spec.name,
                     runs.size(), CountsText(standings), options.keep_stale ? ", stale ones kept" : "",
                     pending.size(), jobs, MinutesSeconds(total_s / jobs),
                     estimate.measured() ? "from finished runs"
                                         : fmt::format("{:.0f} s a run assumed", spec.estimate_s))
      << std::flush;

  Pool pool(pending, estimate, jobs, options, out);
  if (!pool.RunAll()) {
    out << fmt::format("stopped; the same command goes on from here ({})\n", folder.string());
    return 130;
  }
  return Conclude(runs, options, folder, out);
}

}  // namespace atlas::experiments
