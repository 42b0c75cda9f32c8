#include "experiments/sweep/run_pool.h"

#include <fmt/format.h>
#include <signal.h>

#include <ostream>
#include <thread>

#include "core/errors.h"
#include "core/files.h"
#include "core/safe_text.h"
#include "core/text_lines.h"
#include "experiments/report/tables.h"
#include "experiments/results/run_folder.h"

namespace atlas::experiments {
namespace fs = std::filesystem;
namespace {

constexpr auto kPollEvery = std::chrono::milliseconds(100);

double SecondsSince(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// The last line of a child's output, as a terminal may show it.
std::string LastLine(const fs::path& log) {
  std::string text;
  try {
    text = core::ReadFile(log);
  } catch (const core::InputError&) {
    return "no output";
  }
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  const size_t begin = text.find_last_of("\r\n");
  return core::Printable(text.substr(begin == std::string::npos ? 0 : begin + 1));
}

/// The summary that a run left, if it is readable.
std::optional<RunSummary> SummaryOf(const fs::path& folder) {
  try {
    return LoadRunSummary(folder);
  } catch (const core::InputError&) {
    return std::nullopt;
  }
}

/// What an earlier attempt left must not be taken for this one's result; it stays a run, which --force
/// replaces.
void MarkInterrupted(const SweepRun& run) {
  std::error_code error;
  try {
    ClaimLeftovers(run);
    auto summary = SummaryOf(run.folder);
    if (!summary) return;
    summary->status = RunStatus::kInterrupted;
    summary->stop_reason = StopReason::kSignal;
    core::WriteFileAtomically(run.folder / "summary.json", ToJson(*summary));
  } catch (const core::InputError&) {
    fs::remove(run.folder / "summary.json", error);
  }
}

/// Whatever its summary says, the run failed. What cannot be rewritten (a full disk) goes.
void MarkFailed(const fs::path& folder) {
  std::error_code error;
  auto summary = SummaryOf(folder);
  try {
    if (!summary) throw core::InputError("no summary");
    summary->status = RunStatus::kFailed;
    summary->stop_reason = StopReason::kError;
    core::WriteFileAtomically(folder / "summary.json", ToJson(*summary));
  } catch (const core::InputError&) {
    fs::remove(folder / "summary.json", error);
  }
}

}  // namespace

bool EndedOtherwise(const fs::path& folder, RunStatus status) {
  std::error_code error;
  if (!fs::exists(folder / kExitCodeFile, error)) return false;
  const std::string text = core::ReadFile(folder / kExitCodeFile);
  const std::vector<std::string_view> words = core::SplitWords(text);
  return words.size() != 1 || core::ParseNumber<int>(words[0]) != ExitCodeOf(status);
}

void ClaimLeftovers(const SweepRun& run) {
  std::error_code error;
  const bool left = fs::exists(run.folder / kConsoleLog, error) && !RunFileIn(run.folder).empty();
  if (!left || HoldsRun(run.folder)) return;
  ClaimRunFolder(run.folder, core::FileNameFrom(fs::path(run.experiment).stem().string()), run.seed);
}

std::string LabelOf(const SweepRun& run) {
  return (run.folder.parent_path().filename() / run.folder.filename()).string();
}

RunPool::RunPool(const std::vector<SweepRun>& pending, const RunTimeEstimate& estimate, int jobs,
                 double limit_s, const SweepOptions& options, std::ostream& out)
    : pending_(pending),
      estimate_(estimate),
      jobs_(static_cast<size_t>(jobs)),
      limit_s_(limit_s),
      options_(options),
      out_(out) {}

bool RunPool::RunAll() {
  while (next_ < pending_.size() || !active_.empty()) {
    if (options_.should_stop()) {
      EndChildren();
      return false;
    }
    while (active_.size() < jobs_ && next_ < pending_.size()) Start(pending_[next_++]);
    std::this_thread::sleep_for(kPollEvery);
    for (Active& active : active_) {
      const double over_s = SecondsSince(active.begin) - limit_s_;
      if (over_s > 0.0) AskToEnd(&active, over_s);
    }
    Reap();
    ShowProgress();
  }
  ClearLine();
  return true;
}

void RunPool::Start(const SweepRun& run) {
  std::error_code error;
  fs::remove(run.folder / kExitCodeFile, error);
  MarkInterrupted(run);
  fs::create_directories(run.folder, error);
  active_.push_back({&run, ChildProcess(CommandOf(run, options_), run.folder / kConsoleLog), Clock::now()});
}

/// Less and less politely, by the time since it was first asked.
void RunPool::AskToEnd(Active* active, double over_s) const {
  const bool impatient = over_s > options_.interrupt_grace_s;
  if (active->asked == 0) active->child.Signal(SIGINT);
  if (active->asked == 1 && impatient) active->child.Signal(SIGTERM);
  if (over_s > options_.interrupt_grace_s + options_.terminate_grace_s) active->child.Kill();
  active->asked = impatient ? 2 : 1;
}

void RunPool::Reap() {
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

void RunPool::Report(const Active& active, const ChildExit& end) {
  ClearLine();
  const std::string head = fmt::format("[{:{}}/{}] {:<48}", done_ + 1, std::to_string(pending_.size()).size(),
                                       pending_.size(), LabelOf(*active.run));
  const auto left = SummaryOf(active.run->folder);
  const bool as_it_says = left && !end.by_signal && active.asked == 0 && end.code == ExitCodeOf(left->status);
  if (!as_it_says) MarkFailed(active.run->folder);
  if (const auto summary = FinishedRun(*active.run, options_)) {
    const auto number = [&](const char* key) { return summary->Number(key).value_or(0.0); };
    out_ << fmt::format("{} {:<10} c_p {:6.2f} %  {:5.1f} m  {:2.0f} scans  {}\n", head,
                        NameOf(summary->status), 100.0 * number("coverage"), number("travel_distance_m"),
                        number("scans"), MinutesSeconds(SecondsSince(active.begin)));
  } else {
    const std::string how = active.asked > 0 ? fmt::format("no end within {:g} s", limit_s_)
                                             : fmt::format("{} {}", end.by_signal ? "signal" : "exit code",
                                                           end.by_signal ? end.code - 128 : end.code);
    out_ << fmt::format("{} FAILED ({}): {}\n", head, how, LastLine(active.run->folder / kConsoleLog));
  }
  out_.flush();
}

void RunPool::ShowProgress() {
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

void RunPool::ClearLine() {
  if (options_.terminal) out_ << "\r\033[K" << std::flush;
}

void RunPool::EndChildren() {
  ClearLine();
  out_ << fmt::format("stopping {} runs ...\n", active_.size()) << std::flush;
  const Clock::time_point begin = Clock::now();
  while (!active_.empty()) {
    for (Active& active : active_) AskToEnd(&active, SecondsSince(begin));
    std::this_thread::sleep_for(kPollEvery);
    active_.remove_if([](Active& active) { return active.child.Poll().has_value(); });
  }
}

}  // namespace atlas::experiments
