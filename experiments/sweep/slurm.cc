#include "experiments/sweep/slurm.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <ostream>
#include <sstream>
#include <thread>

#include "core/files.h"
#include "core/safe_text.h"
#include "core/text_lines.h"
#include "experiments/sweep/child_process.h"
#include "experiments/sweep/run_pool.h"

namespace atlas::experiments {
namespace fs = std::filesystem;
namespace {

fs::path FindOnPath(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::stringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path candidate = fs::path(folder) / program;
    if (access(candidate.c_str(), X_OK) == 0) return candidate;
  }
  return {};
}

std::string BatchScript(const SweepSpec& spec, size_t runs, const SweepOptions& options,
                        const fs::path& folder) {
  const std::string at_once = options.jobs > 0 ? fmt::format("%{}", options.jobs) : "";
  return fmt::format(
      "#!/bin/bash\n"
      "#SBATCH --job-name=atlas_{}\n"
      "#SBATCH --array=1-{}{}\n"
      "#SBATCH --cpus-per-task={}\n"
      "#SBATCH --mem=4G\n"
      "#SBATCH --time={}\n"
      "#SBATCH --output=/dev/null\n"
      "set -eu\n"
      "cd {}\n"
      "eval \"$(sed -n \"${{SLURM_ARRAY_TASK_ID}}p\" {})\"\n",
      core::FileNameFrom(spec.name), runs, at_once, options.threads, std::ceil(LimitOf(spec) / 60.0),
      core::ShellQuoted(fs::current_path().string()),
      core::ShellQuoted((fs::absolute(folder) / "runs.txt").string()));
}

}  // namespace

int SubmitToSlurm(const SweepSpec& spec, const std::vector<SweepRun>& runs, const SweepOptions& options,
                  const fs::path& folder, std::ostream& out) {
  SweepOptions remote = options;
  remote.executable = fs::canonical(options.executable);  // /proc/self/exe means another file elsewhere
  std::string lines;
  for (const SweepRun& run : runs) {
    fs::create_directories(run.folder);
    ClaimLeftovers(run);
    std::string line;
    for (const std::string& word : CommandOf(run, remote)) line += core::ShellQuoted(word) + " ";
    const std::string log = core::ShellQuoted((run.folder / kConsoleLog).string()),
                      code = core::ShellQuoted((run.folder / kExitCodeFile).string());
    lines += fmt::format("rm -f -- {0}; {1}> {2} 2>&1 || echo $? > {0}\n", code, line, log);
  }
  const fs::path script = folder / "sweep.sbatch";
  core::WriteFileAtomically(folder / "runs.txt", lines);
  core::WriteFileAtomically(script, BatchScript(spec, runs.size(), options, folder));
  out << fmt::format("{} runs in {}\n", runs.size(), (folder / "runs.txt").string());

  const fs::path sbatch = FindOnPath("sbatch");
  if (sbatch.empty()) {
    out << fmt::format("sbatch is not installed here; on the cluster: sbatch {}\n",
                       core::ShellQuoted(script.string()));
    return 0;
  }
  const fs::path log = folder / "sbatch.log";
  ChildProcess child({sbatch.string(), script.string()}, log);
  std::optional<ChildExit> end;
  while (!(end = child.Poll())) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  const std::string answer = core::ReadFile(log);
  core::TextLines answer_lines(answer);
  while (const auto line = answer_lines.Next()) out << core::Printable(*line) << "\n";
  if (end->code != 0) {
    out << fmt::format("sbatch failed with code {}\n", end->code);
    return 1;
  }
  out << fmt::format("when it has ended: atlas sweep {} --out {}\n", core::ShellQuoted(spec.name),
                     core::ShellQuoted(folder.string()));
  return 0;
}

}  // namespace atlas::experiments
