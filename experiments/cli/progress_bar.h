// A bar of progress with the time that is left, on standard error.
#pragma once

#include <string>

#include "core/stopwatch.h"
#include "experiments/cli/progress_line.h"

namespace atlas::experiments {

/// "scans  [#######-------]  45/130  3.4/s  0:25 left  12 MB". Rewrites itself on a terminal; elsewhere only
/// the end of each task appears.
class ProgressBar {
 public:
  ProgressBar(std::string task, size_t total) : task_(std::move(task)), total_(total) {}
  void Show(size_t done, const std::string& note);
  /// Ends the line: what was done, in how long.
  void Finish(const std::string& note);

 private:
  std::string task_;
  size_t total_;
  double shown_at_s_ = -1.0;
  core::Stopwatch watch_;
  ProgressLine line_;
};

}  // namespace atlas::experiments
