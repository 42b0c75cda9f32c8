#include "experiments/cli/progress_bar.h"

#include <fmt/format.h>

#include "experiments/report/tables.h"

namespace atlas::experiments {

void ProgressBar::Show(size_t done, const std::string& note) {
  constexpr size_t kWidth = 24;
  constexpr double kEverySeconds = 0.1;
  const double now_s = watch_.seconds();
  if (shown_at_s_ >= 0.0 && now_s < shown_at_s_ + kEverySeconds) return;
  shown_at_s_ = now_s;
  const size_t filled = kWidth * done / std::max<size_t>(total_, 1);
  std::string rate;
  if (done > 0 && now_s > 0.0) {
    const double each_s = now_s / static_cast<double>(done);
    rate = fmt::format("  {:.1f}/s  {} left", 1.0 / each_s,
                       MinutesSeconds(each_s * static_cast<double>(total_ - done)));
  }
  line_.Show(fmt::format("{}  [{:#<{}}{:-<{}}]  {}/{}{}  {}", task_, "", filled, "", kWidth - filled, done,
                         total_, rate, note),
             false);
}

void ProgressBar::Finish(const std::string& note) {
  line_.Show(fmt::format("{}: {} ({:.1f} s)", task_, note, watch_.seconds()), true);
}

}  // namespace atlas::experiments
