// What holds for every command: its arguments, its output, its errors.
#pragma once

#include <functional>

namespace atlas::experiments {

/// Runs `command` and returns the process's exit code: the command's own; 2 for InputError and for arguments
/// with control characters, 1 for any other exception, each told in one line on standard error; 1 instead of
/// 0 where standard output did not take all that was written (a full disk).
int RunProcess(int argc, char** argv, const std::function<int()>& command);

}  // namespace atlas::experiments
