// A running ffmpeg that is fed raw frames.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace atlas::experiments {

class FfmpegPipe {
 public:
  /// What ffmpeg calls the file that is open as `output`. Names from users never reach it, where a name may
  /// be an option ("-x.mp4"), a protocol ("pipe:1", "http://...") or by now a link to elsewhere.
  static constexpr const char* kOutput = "file:/dev/fd/3";

  /// Starts `ffmpeg ARGUMENTS`, which reads frames from its standard input.
  /// @param output  open for reading and writing: what ffmpeg writes as kOutput; -1: none
  /// @throws InputError where ffmpeg is not installed.
  explicit FfmpegPipe(const std::vector<std::string>& arguments, int output = -1);
  ~FfmpegPipe();  ///< abandons what is not finished
  FfmpegPipe(const FfmpegPipe&) = delete;
  FfmpegPipe& operator=(const FfmpegPipe&) = delete;

  /// @throws InputError with ffmpeg's own words when it has given up.
  void Write(std::span<const uint8_t> bytes);
  /// Ends the input and waits. @throws InputError with ffmpeg's own words when it failed.
  void Finish();

 private:
  [[noreturn]] void Fail();
  int Wait();

  int input_ = -1;     ///< our end of its standard input
  int messages_ = -1;  ///< a file with no name that holds its standard error
  int process_ = -1;
};

}  // namespace atlas::experiments
