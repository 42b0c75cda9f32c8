// Ctrl-C.
#pragma once

namespace atlas::experiments {

/// From now on SIGINT and SIGTERM ask the run to stop; a second one ends the process at once.
void InstallInterruptHandler();
bool Interrupted();

}  // namespace atlas::experiments
