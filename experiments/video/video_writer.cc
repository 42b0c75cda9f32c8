#include "experiments/video/video_writer.h"

#include <fmt/format.h>

#include <cassert>

namespace atlas::experiments {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> RawInput(int width, int height, double rate) {
  return {"-f",       "rawvideo",
          "-pix_fmt", "rgb24",
          "-s",       fmt::format("{}x{}", width, height),
          "-r",       fmt::format("{}", rate),
          "-i",       "-",
          "-an",      "-y"};
}

std::vector<std::string> Mp4Arguments(int width, int height, double rate) {
  std::vector<std::string> arguments = RawInput(width, height, rate);
  for (const char* word : {"-c:v", "libx264", "-preset", "veryfast", "-crf", "21", "-pix_fmt", "yuv420p",
                           "-movflags", "+faststart", "-f", "mp4"}) {
    arguments.emplace_back(word);
  }
  arguments.emplace_back(FfmpegPipe::kOutput);
  return arguments;
}

}  // namespace

VideoWriter::VideoWriter(const fs::path& path, int width, int height, double frames_per_second)
    : file_(path),
      width_(width),
      height_(height),
      ffmpeg_(Mp4Arguments(width, height, frames_per_second), file_.descriptor()) {
  assert(width % 2 == 0 && height % 2 == 0);
}

void VideoWriter::Add(const sim::RgbImage& frame) {
  assert(frame.width == width_ && frame.height == height_);
  ffmpeg_.Write(frame.rgb);
}

void VideoWriter::Finish() {
  ffmpeg_.Finish();
  file_.Commit();
}

void WritePng(const fs::path& path, const sim::RgbImage& image) {
  core::TemporaryFile file(path);
  std::vector<std::string> arguments = RawInput(image.width, image.height, 1.0);
  for (const char* word : {"-frames:v", "1", "-c:v", "png", "-f", "image2pipe"}) arguments.emplace_back(word);
  arguments.emplace_back(FfmpegPipe::kOutput);
  FfmpegPipe ffmpeg(arguments, file.descriptor());
  ffmpeg.Write(image.rgb);
  ffmpeg.Finish();
  file.Commit();
}

}  // namespace atlas::experiments
