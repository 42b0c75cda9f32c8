// Signals that ask a command to stop: Ctrl-C (SIGINT), SIGTERM, a closed terminal (SIGHUP), a closed pipe
// (SIGPIPE).
#pragma once

namespace atlas::experiments {

/// Writing beyond a limit on file sizes is from now on an error of that write (EFBIG), not the end of the
/// process. For all commands.
void TakeFileSizeLimitsAsErrors();

/// From now on a signal ends the process at once, with exit code 130: while there is nothing to lose, so that
/// neither long preparations nor the libraries below them need to ask. SIGHUP and SIGPIPE stay ignored where
/// the caller ignores them (nohup).
void EndAtOnceOnSignal();
/// From now on a signal asks the command to stop in order (Interrupted); a second SIGINT or SIGTERM ends the
/// process at once.
void StopInOrderOnSignal();
bool Interrupted();

}  // namespace atlas::experiments
