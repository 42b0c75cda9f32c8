// A real process to send real signals to.
#pragma once

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace atlas::tests {

/// Polls until `condition` holds or `limit_s` has passed; whether it holds.
inline bool Eventually(const std::function<bool()>& condition, double limit_s = 120.0) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(limit_s);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

struct ChildOptions {
  std::filesystem::path folder = ".";  ///< it runs there
  std::filesystem::path out = "/dev/null", error = "/dev/null";
  std::vector<std::pair<std::string, std::string>> environment = {};
  rlim_t largest_file = RLIM_INFINITY;
};

class Child {
 public:
  Child(const std::vector<std::string>& arguments, const ChildOptions& options) {
    std::vector<char*> argv;
    for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ != 0) return;
    setpgid(0, 0);
    for (const auto& [name, value] : options.environment) setenv(name.c_str(), value.c_str(), 1);
    const rlimit limit{options.largest_file, RLIM_INFINITY};
    if (setrlimit(RLIMIT_FSIZE, &limit) != 0 || chdir(options.folder.c_str()) != 0 ||
        freopen("/dev/null", "r", stdin) == nullptr || freopen(options.out.c_str(), "a", stdout) == nullptr ||
        freopen(options.error.c_str(), "a", stderr) == nullptr) {
      _exit(99);
    }
    execv(argv[0], argv.data());
    _exit(99);
  }
  ~Child() {
    if (pid_ <= 0) return;
    kill(-pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  pid_t pid() const { return pid_; }
  void Signal(int number) const { kill(pid_, number); }

  /// Its exit code, -SIGNAL where a signal ended it, or -999 where it goes on for longer than `limit_s`.
  int Wait(double limit_s = 120.0) {
    int status = 0;
    const auto over = [&] { return waitpid(pid_, &status, WNOHANG) == pid_; };
    if (!Eventually(over, limit_s)) return -999;
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

 private:
  pid_t pid_ = -1;
};

}  // namespace atlas::tests
