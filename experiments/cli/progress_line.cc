#include "experiments/cli/progress_line.h"

#include <unistd.h>

#include <iostream>

namespace atlas::experiments {

void ProgressLine::Show(const std::string& line, bool final) {
  if (isatty(STDERR_FILENO) == 1) {
    std::cerr << "\r\033[K" << line << (final ? "\n" : "") << std::flush;
  } else if (final) {
    std::cerr << line << std::endl;
  }
  if (final) log_ += line + "\n";
}

}  // namespace atlas::experiments
