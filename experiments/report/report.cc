#include "experiments/report/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <ostream>

#include "core/errors.h"
#include "core/files.h"
#include "core/safe_text.h"
#include "experiments/report/tables.h"

namespace atlas::experiments {
namespace fs = std::filesystem;
namespace {

/// Folders with a summary.json at or below `root`, sorted with numbers in numeric order (seed 2 before 10).
std::vector<fs::path> RunFoldersBelow(const fs::path& root) {
  std::error_code error;
  if (!fs::is_directory(root, error)) throw core::InputError(root.string() + ": no such folder");
  std::vector<fs::path> folders;
  if (fs::exists(root / "summary.json", error)) folders.push_back(root);
  for (auto entry =
           fs::recursive_directory_iterator(root, fs::directory_options::skip_permission_denied, error);
       entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    if (entry->is_directory(error) && fs::exists(entry->path() / "summary.json", error))
      folders.push_back(entry->path());
  }
  std::sort(folders.begin(), folders.end(), [](const fs::path& a, const fs::path& b) {
    if (a.parent_path() != b.parent_path()) return a.parent_path() < b.parent_path();
    const std::string x = a.filename().string(), y = b.filename().string();
    const auto digits = [](const std::string& s) {
      return s.find_first_not_of("0123456789") == std::string::npos;
    };
    return digits(x) && digits(y) && x.size() != y.size() ? x.size() < y.size() : x < y;
  });
  return folders;
}

std::string CommandOf(const std::vector<fs::path>& folders, const fs::path& out) {
  std::string command = "./atlas report";
  for (const fs::path& folder : folders) command += fmt::format(" {}", core::ShellQuoted(folder.string()));
  return out.empty() ? command : fmt::format("{} --out {}", command, core::ShellQuoted(out.string()));
}

void WritePlots(const std::vector<RunGroup>& groups, const fs::path& folder) {
  for (const std::string& object : ObjectsOf(groups)) {
    core::WriteFileAtomically(folder / ("coverage_" + core::FileNameFrom(object) + ".svg"),
                              CoverageByScanPlot(object, groups));
  }
}

}  // namespace

std::vector<std::string> ObjectsOf(const std::vector<RunGroup>& groups) {
  std::vector<std::string> objects;
  for (const RunGroup& group : groups) {
    if (std::count(objects.begin(), objects.end(), group.object) == 0) objects.push_back(group.object);
  }
  return objects;
}

int RunReport(const std::vector<fs::path>& folders, const fs::path& out, std::ostream& log) {
  if (folders.empty()) throw core::InputError("report: name at least one run folder");
  std::vector<ReportedRun> runs;
  std::vector<std::string> skipped;
  for (const fs::path& root : folders) {
    for (const fs::path& folder : RunFoldersBelow(root)) {
      try {
        ReportedRun run = LoadReportedRun(folder);
        run.curve = LoadCoverageCurve(folder);
        runs.push_back(std::move(run));
      } catch (const core::InputError& error) {
        skipped.push_back(error.what());
        log << "left out: " << error.what() << "\n";
      }
    }
  }
  if (runs.empty()) {
    throw core::InputError(fmt::format("{}: no run folder with a readable summary.json there or below",
                                       folders.front().string()));
  }
  const fs::path target = out.empty() ? folders.front() : out;
  core::RemoveStaleTemporaries(target);
  const GroupedRuns grouped = GroupRuns(runs);
  WriteTables(grouped, CommandOf(folders, out), target);
  WritePlots(grouped.groups, target);
  core::WriteFileAtomically(target / "report.html", HtmlPage(grouped, skipped));
  log << CoverageTable(grouped) << "\nreport: " << (target / "report.html").string() << "\n";
  return 0;
}

}  // namespace atlas::experiments
