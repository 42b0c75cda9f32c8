// One child process with its output in a file.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace atlas::experiments {

/// How a child ended: exit code, or 128 + signal.
struct ChildExit {
  int code = 0;
  bool by_signal = false;
};

class ChildProcess {
 public:
  /// Starts `arguments[0]` with stdout and stderr in `log` (a new file: no link is followed), stdin empty.
  /// The child has a process group of its own (a Ctrl-C at the terminal reaches only us) and is asked to end
  /// (SIGTERM) when this process dies. @throws InputError when it cannot be started.
  ChildProcess(const std::vector<std::string>& arguments, const std::filesystem::path& log);
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;
  /// Ends a child that still runs, with all of its group, and reaps it.
  ~ChildProcess();

  /// How it ended, or nullopt while it runs. Does not wait. What is left of its group then ends too.
  std::optional<ChildExit> Poll();
  /// Sends a signal to the child alone; nothing once it has ended.
  void Signal(int number) const;
  /// SIGKILL to its whole group; nothing once it has ended.
  void Kill() const;
  pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = -1;
  std::optional<ChildExit> exit_;
};

}  // namespace atlas::experiments
