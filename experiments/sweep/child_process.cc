#include "experiments/sweep/child_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/errors.h"

namespace atlas::experiments {
namespace {

/// After fork: only calls that are safe there.
[[noreturn]] void BecomeChild(char* const* argv, int log, int null, pid_t parent) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(127);
  dup2(null, STDIN_FILENO);
  dup2(log, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  for (const int number : {SIGINT, SIGTERM, SIGPIPE, SIGXFSZ}) signal(number, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  execv(argv[0], argv);
  _exit(127);
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& arguments, const std::filesystem::path& log) {
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  unlink(log.c_str());  // of an earlier attempt
  const int log_file = open(log.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644);
  const int null_file = open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (log_file < 0 || null_file < 0) {
    const std::string reason = std::strerror(errno);
    if (log_file >= 0) close(log_file);
    if (null_file >= 0) close(null_file);
    throw core::InputError(fmt::format("{}: cannot write ({})", log.string(), reason));
  }
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ == 0) BecomeChild(argv.data(), log_file, null_file, parent);
  const std::string reason = std::strerror(errno);
  if (pid_ > 0) setpgid(pid_, pid_);  // by whichever comes first, so that its group is there to be signalled
  close(log_file);
  close(null_file);
  if (pid_ < 0) throw core::InputError(fmt::format("cannot start a process ({})", reason));
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept : pid_(other.pid_), exit_(other.exit_) {
  other.pid_ = -1;
}

ChildProcess::~ChildProcess() {
  if (pid_ < 0 || exit_) return;
  Kill();
  while (waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

std::optional<ChildExit> ChildProcess::Poll() {
  if (exit_ || pid_ < 0) return exit_;
  siginfo_t info = {};
  if (waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) != 0 || info.si_pid != pid_)
    return std::nullopt;
  kill(-pid_, SIGKILL);  // while the child is not reaped, nobody else's group has its number
  int status = 0;
  while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) {
    exit_ = ChildExit{128 + WTERMSIG(status), true};
  } else {
    exit_ = ChildExit{WEXITSTATUS(status), false};
  }
  return exit_;
}

void ChildProcess::Signal(int number) const {
  if (pid_ > 0 && !exit_) kill(pid_, number);
}

void ChildProcess::Kill() const {
  if (pid_ > 0 && !exit_) kill(-pid_, SIGKILL);
}

}  // namespace atlas::experiments
