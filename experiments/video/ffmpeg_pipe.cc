#include "experiments/video/ffmpeg_pipe.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>

#include "core/errors.h"

extern char** environ;

namespace atlas::experiments {
namespace {

constexpr int kOutputDescriptor = 3;  // of kOutput

}  // namespace

FfmpegPipe::FfmpegPipe(const std::vector<std::string>& arguments, int output) {
  // Without -xerror an end of file that cannot be written is no failure.
  std::vector<std::string> words = {"ffmpeg", "-hide_banner", "-nostats", "-loglevel", "error", "-xerror"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  // A socket rather than a pipe: writing to a dead ffmpeg is then an error instead of a signal.
  int ends[2] = {-1, -1};
  messages_ = memfd_create("ffmpeg_messages", MFD_CLOEXEC);
  if (messages_ < 0 || socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
    throw core::InputError(std::string("video: cannot start ffmpeg (") + std::strerror(errno) + ")");
  }
  input_ = ends[0];
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, messages_, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, messages_, STDERR_FILENO);
  if (output >= 0)
    posix_spawn_file_actions_adddup2(&actions, output, kOutputDescriptor);  // the last: may be a source
  const int error = posix_spawnp(&process_, "ffmpeg", &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  if (error == 0) return;
  process_ = -1;
  close(input_);
  close(messages_);
  throw core::InputError(error == ENOENT
                             ? std::string("video: ffmpeg is not installed (Debian package ffmpeg)")
                             : std::string("video: cannot start ffmpeg (") + std::strerror(error) + ")");
}

FfmpegPipe::~FfmpegPipe() {
  if (input_ >= 0) close(input_);
  if (process_ > 0) {
    kill(process_, SIGTERM);
    Wait();
  }
  close(messages_);
}

void FfmpegPipe::Write(std::span<const uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = send(input_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) Fail();
    bytes = bytes.subspan(static_cast<size_t>(sent));
  }
}

void FfmpegPipe::Finish() {
  close(input_);
  input_ = -1;
  if (Wait() != 0) Fail();
}

int FfmpegPipe::Wait() {
  int status = 0;
  while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = -1;
  return status;
}

void FfmpegPipe::Fail() {
  char text[400] = "";
  const ssize_t size = pread(messages_, text, sizeof text - 1, 0);
  std::string words(text, size > 0 ? static_cast<size_t>(size) : 0);
  words = words.substr(0, words.find('\n'));
  throw core::InputError("video: ffmpeg failed" + (words.empty() ? words : " (" + words + ")"));
}

}  // namespace atlas::experiments
