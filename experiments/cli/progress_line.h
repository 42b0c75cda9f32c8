// A line of progress on standard error.
#pragma once

#include <string>

namespace atlas::experiments {

/// Rewrites itself on a terminal; elsewhere only final lines appear.
class ProgressLine {
 public:
  void Show(const std::string& line, bool final);
};

}  // namespace atlas::experiments
