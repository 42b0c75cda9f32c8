#include "experiments/cli/interrupt.h"

#include <unistd.h>
#include <initializer_list>

#include <csignal>

namespace atlas::experiments {
namespace {

constexpr int kInterruptedCode = 130;

// A signal handler can reach nothing else.
volatile std::sig_atomic_t g_in_order = 0, g_signals = 0, g_asked = 0;

void OnSignal(int number) {
  g_signals = 1;
  // Others come in numbers by themselves: a pipe's at each write, a terminal's from the shell and the kernel.
  if (number == SIGINT || number == SIGTERM) g_asked = g_asked + 1;
  if (g_in_order != 0 && g_asked <= 1) return;
  constexpr char kMessage[] = "\natlas: stopped\n";
  [[maybe_unused]] const ssize_t sent = write(STDERR_FILENO, kMessage, sizeof kMessage - 1);
  _exit(kInterruptedCode);
}

void Install(bool in_order) {
  g_in_order = in_order ? 1 : 0;
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) {
    struct sigaction action = {};
    sigaction(number, nullptr, &action);
    if (action.sa_handler == SIG_IGN && (number == SIGHUP || number == SIGPIPE)) continue;
    action = {};
    action.sa_handler = OnSignal;
    sigaction(number, &action, nullptr);
  }
}

}  // namespace

void TakeFileSizeLimitsAsErrors() {
  std::signal(SIGXFSZ, SIG_IGN);
}

void EndAtOnceOnSignal() {
  Install(false);
}

void StopInOrderOnSignal() {
  Install(true);
}

bool Interrupted() {
  return g_signals > 0;
}

}  // namespace atlas::experiments
