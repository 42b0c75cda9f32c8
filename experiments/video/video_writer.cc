#include "experiments/video/video_writer.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cassert>

#include "core/errors.h"

namespace atlas::experiments {
namespace {

namespace fs = std::filesystem;

fs::path Beside(const fs::path& path) {
  std::error_code error;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), error);
  return path.string() + fmt::format(".tmp{}", ::getpid());
}

void Rename(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error) throw core::InputError(fmt::format("{}: cannot write ({})", to.string(), error.message()));
}

std::vector<std::string> RawInput(int width, int height, double rate) {
  return {"-f",       "rawvideo",
          "-pix_fmt", "rgb24",
          "-s",       fmt::format("{}x{}", width, height),
          "-r",       fmt::format("{}", rate),
          "-i",       "-",
          "-an",      "-y"};
}

std::vector<std::string> Mp4Arguments(const fs::path& path, int width, int height, double rate) {
  std::vector<std::string> arguments = RawInput(width, height, rate);
  for (const char* word : {"-c:v", "libx264", "-preset", "veryfast", "-crf", "21", "-pix_fmt", "yuv420p",
                           "-movflags", "+faststart", "-f", "mp4"}) {
    arguments.emplace_back(word);
  }
  arguments.push_back(path.string());
  return arguments;
}

}  // namespace

VideoWriter::VideoWriter(const fs::path& path, int width, int height, double frames_per_second)
    : path_(path),
      beside_(Beside(path)),
      width_(width),
      height_(height),
      ffmpeg_(std::make_unique<FfmpegPipe>(Mp4Arguments(beside_, width, height, frames_per_second))) {
  assert(width % 2 == 0 && height % 2 == 0);
}

VideoWriter::~VideoWriter() {
  ffmpeg_.reset();  // before the file goes, or it might write another
  std::error_code error;
  fs::remove(beside_, error);
}

void VideoWriter::Add(const sim::RgbImage& frame) {
  assert(frame.width == width_ && frame.height == height_);
  ffmpeg_->Write(frame.rgb);
}

void VideoWriter::Finish() {
  ffmpeg_->Finish();
  Rename(beside_, path_);
}

void WritePng(const fs::path& path, const sim::RgbImage& image) {
  const fs::path beside = Beside(path);
  std::vector<std::string> arguments = RawInput(image.width, image.height, 1.0);
  for (const char* word : {"-frames:v", "1", "-c:v", "png", "-f", "image2pipe"}) arguments.emplace_back(word);
  arguments.push_back("file:" + beside.string());
  FfmpegPipe ffmpeg(arguments);
  ffmpeg.Write(image.rgb);
  ffmpeg.Finish();
  Rename(beside, path);
}

}  // namespace atlas::experiments
