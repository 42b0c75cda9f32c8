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
  /// Starts `ffmpeg ARGUMENTS`, which reads frames from its standard input.
  /// @throws InputError where ffmpeg is not installed.
  explicit FfmpegPipe(const std::vector<std::string>& arguments);
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
