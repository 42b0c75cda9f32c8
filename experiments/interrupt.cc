#include "experiments/interrupt.h"

#include <unistd.h>

#include <csignal>

namespace atlas::experiments {
namespace {

volatile std::sig_atomic_t g_signals = 0;  // a signal handler can reach nothing else

void OnSignal(int) {
  g_signals = g_signals + 1;
  if (g_signals > 1) _exit(130);
}

}  // namespace

void InstallInterruptHandler() {
  struct sigaction action = {};
  action.sa_handler = OnSignal;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool Interrupted() {
  return g_signals > 0;
}

}  // namespace atlas::experiments
