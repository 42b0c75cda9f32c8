// Frames to files: H.264 video and PNG pictures, by ffmpeg.
#pragma once

#include <filesystem>

#include "core/temporary_file.h"
#include "experiments/video/ffmpeg_pipe.h"
#include "sim/render/colored_mesh.h"

namespace atlas::experiments {

/// Writes an mp4 (H.264, 4:2:0) that appears under its name when it is finished; an unfinished one vanishes.
class VideoWriter {
 public:
  /// Width and height are even. @throws InputError where ffmpeg is missing or the folder cannot be written.
  VideoWriter(const std::filesystem::path& path, int width, int height, double frames_per_second);

  /// @pre the frame has the video's size. @throws InputError with ffmpeg's own words when it has given up.
  void Add(const sim::RgbImage& frame);
  /// @throws InputError when the video cannot be completed.
  void Finish();

 private:
  core::TemporaryFile file_;
  int width_, height_;
  FfmpegPipe ffmpeg_;  ///< ends before its file goes
};

/// Whole or not at all. @throws InputError where ffmpeg is missing or the file cannot be written.
void WritePng(const std::filesystem::path& path, const sim::RgbImage& image);

}  // namespace atlas::experiments
