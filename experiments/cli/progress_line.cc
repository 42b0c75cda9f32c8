#include "experiments/cli/progress_line.h"

#include <unistd.h>

#include <iostream>

#include "core/safe_text.h"

namespace atlas::experiments {

void ProgressLine::Show(const std::string& text, bool final) {
  const std::string line = core::Printable(text);
  if (isatty(STDERR_FILENO) == 1) {
    std::cerr << "\r\033[K" << line << (final ? "\n" : "") << std::flush;
  } else if (final) {
    std::cerr << line << std::endl;
  }
}

}  // namespace atlas::experiments
