#include "experiments/cli/process.h"

#include <fmt/format.h>
#include <unistd.h>

#include <exception>
#include <iostream>

#include "core/errors.h"
#include "core/safe_text.h"
#include "experiments/cli/interrupt.h"

namespace atlas::experiments {
namespace {

/// Ends a progress line that may stand there, where someone watches.
const char* FreshLine() {
  return isatty(STDERR_FILENO) != 0 ? "\n" : "";
}

void CheckTextOfArguments(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) core::RefuseControlCharacters(argv[i], fmt::format("argument {}", i));
}

int FinishOutput(int code) {
  std::cout.flush();
  if (std::cout) return code;
  std::cerr << FreshLine() << "atlas: standard output: cannot write\n";
  return code == 0 ? 1 : code;
}

}  // namespace

int RunProcess(int argc, char** argv, const std::function<int()>& command) {
  TakeFileSizeLimitsAsErrors();
  try {
    CheckTextOfArguments(argc, argv);
    return FinishOutput(command());
  } catch (const core::InputError& error) {
    std::cerr << FreshLine() << "atlas: " << error.what() << "\n";
    return 2;
  } catch (const std::exception& error) {
    std::cerr << FreshLine() << "atlas: internal error: " << core::Printable(error.what()) << "\n";
    return 1;
  }
}

}  // namespace atlas::experiments
