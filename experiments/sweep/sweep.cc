#include "experiments/sweep/sweep.h"

#include <fmt/format.h>

#include <map>
#include <ostream>

#include "core/cpus.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/folder_lock.h"
#include "core/safe_text.h"
#include "experiments/report/mapper_pairs.h"
#include "experiments/report/tables.h"
#include "experiments/sweep/run_pool.h"
#include "experiments/sweep/slurm.h"

namespace atlas::experiments {
namespace fs = std::filesystem;
namespace {

/// Held while a sweep runs in a folder, so that two cannot mix their runs.
core::FolderLock Locked(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  return core::FolderLock(folder);
}

/// @throws InputError: what is wrong with a run of the sweep, naming its file and the field that set it.
[[noreturn]] void FailIn(const SweepSpec& spec, const SweepRun& run, const std::string& what) {
  for (const std::string& assignment : run.assignments) {
    const std::string start = "--set " + assignment;
    const auto place = spec.places.find(assignment);
    if (place != spec.places.end() && what.starts_with(start + ":"))
      throw core::InputError(fmt::format("{}: {}{}", place->second, assignment, what.substr(start.size())));
  }
  const std::string file = spec.file.empty() ? "sweep " + spec.name : spec.file;
  throw core::InputError(fmt::format("{}: {}: {}", file, run.experiment, what));
}

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
                                (run.folder / kConsoleLog).string()));
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
  for (const std::string& word : command) core::RefuseControlCharacters(word, "sweep: " + LabelOf(run));
  return command;
}

std::vector<SweepRun> IdentifiedRuns(const SweepSpec& spec, const SweepOptions& options,
                                     const fs::path& folder) {
  std::vector<SweepRun> runs = ExpandSweep(spec, folder);
  std::map<fs::path, std::shared_ptr<const RunIdentity>> known;  // seeds share one
  for (SweepRun& run : runs) {
    std::shared_ptr<const RunIdentity>& identity = known[run.folder.parent_path()];
    if (!identity) {
      try {
        identity = std::make_shared<const RunIdentity>(options.identify(run.experiment, run.assignments));
      } catch (const core::InputError& error) {
        FailIn(spec, run, error.what());
      }
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
    const auto wall_s = summary ? summary->Number("wall_time_s") : std::nullopt;
    if (wall_s) walls_.push_back({run.experiment, run.folder.parent_path(), *wall_s});
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
  const core::FolderLock lock = Locked(folder);
  core::RemoveStaleTemporaries(folder);

  std::vector<SweepRun> pending;
  std::vector<RunStanding> standings;
  for (const SweepRun& run : runs) {
    standings.push_back(StandingOf(run));
    if (!FinishedRun(run, options)) pending.push_back(run);
  }
  if (options.slurm) return SubmitToSlurm(spec, pending, options, folder, out);

  const int cores = core::AvailableCpus();
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

  RunPool pool(pending, estimate, jobs, LimitOf(spec), options, out);
  if (!pool.RunAll()) {
    out << fmt::format("stopped; the same command goes on from here ({})\n", folder.string());
    return 130;
  }
  return Conclude(runs, options, folder, out);
}

}  // namespace atlas::experiments
