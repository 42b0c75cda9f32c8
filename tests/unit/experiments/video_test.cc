#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <set>

#include "core/errors.h"
#include "core/files.h"
#include "core/rng.h"
#include "experiments/video/overlays.h"
#include "experiments/video/run_video.h"
#include "experiments/video/video_writer.h"
#include "sim/render/robot_figure.h"
#include "tests/support/sensor_scenes.h"

namespace atlas::experiments {
namespace {

namespace fs = std::filesystem;

class VideoTest : public ::testing::Test {
 protected:
  VideoTest() : folder_(fs::temp_directory_path() / ("atlas_video_test" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
  }
  ~VideoTest() override { fs::remove_all(folder_); }
  size_t FilesInFolder() const {
    return static_cast<size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator{}));
  }
  fs::path folder_;
};

std::string OutputOf(const std::string& command) {
  std::string text;
  FILE* pipe = popen(command.c_str(), "r");
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text.push_back(static_cast<char>(c));
  pclose(pipe);
  return text;
}

std::vector<double> StandingAt(double x, double y) {
  return {x, y, 0.5, 1, 0, 0, 0, 0, 0.6, 1.0, 0, 0.6, 1.0, 0, 0.6, 1.0, 0, 0.6, 1.0};
}

RunRecording ShortRun() {
  RunRecording run;
  run.scene = "none";
  run.robot = "quadruped";
  for (int i = 0; i <= 40; ++i) run.states.push_back({0.1 * i, StandingAt(0.05 * i, 0)});
  run.keyframes.push_back(
      {1.0, {{0.025f, 1.025f, 0.525f}, {0.075f, 1.025f, 0.525f}}, {{0, 0}, {2, 0}}, ChosenView{{2, 0}, 1}});
  run.keyframes.push_back({3.0, {{0.075f, 1.025f, 0.525f}, {-0.025f, -1.025f, 0.025f}}, {}, std::nullopt});
  return run;
}

scenes::SceneSpec Floor() {
  core::Pose below = core::Pose::Identity();
  below.translation().z() = -0.1;
  scenes::SceneSpec scene =
      sim::testing::Scene({sim::testing::Part(sim::testing::BoxMesh({30, 30, 0.1}, below))});
  scene.object_box = {core::Vec3(-1, 4, 0), core::Vec3(1, 6, 2)};
  return scene;
}

TEST_F(VideoTest, RecordingSurvivesItsFile) {
  const RunRecording run = ShortRun();
  SaveRecording(folder_ / "run.bin", run);
  const RunRecording again = LoadRecording(folder_ / "run.bin");
  EXPECT_EQ(again.robot, run.robot);
  ASSERT_EQ(again.states.size(), run.states.size());
  EXPECT_EQ(again.states[7].time_s, run.states[7].time_s);
  for (size_t i = 0; i < 19; ++i) EXPECT_NEAR(again.states[7].qpos[i], run.states[7].qpos[i], 1e-6);
  ASSERT_EQ(again.keyframes.size(), 2u);
  for (size_t k = 0; k < 2; ++k) {
    const auto order = [](const core::Vec3f& a, const core::Vec3f& b) {
      return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
    };
    std::vector<core::Vec3f> before = run.keyframes[k].occupied_map, after = again.keyframes[k].occupied_map;
    std::sort(before.begin(), before.end(), order);
    std::sort(after.begin(), after.end(), order);
    ASSERT_EQ(before.size(), after.size());
    for (size_t i = 0; i < before.size(); ++i) EXPECT_LT((before[i] - after[i]).norm(), 1e-5f);
    EXPECT_EQ(again.keyframes[k].path_map, run.keyframes[k].path_map);
    EXPECT_EQ(again.keyframes[k].view.has_value(), run.keyframes[k].view.has_value());
  }
  EXPECT_EQ(again.keyframes[0].view->p_map.x(), 2.0);
}

TEST_F(VideoTest, RecordingMadeAsTheRunGoesIsTheSameAndReadableAtAnyTime) {
  const RunRecording run = ShortRun();
  RecordingWriter writer(run.scene, run.robot, run.resolution_m);
  const std::vector<core::Vec3f>& map = run.keyframes[0].occupied_map;
  for (int i = 0; i < 15; ++i) writer.AddState(run.states[static_cast<size_t>(i)]);
  writer.AddMap(1.0, {map.rbegin(), map.rend()});
  writer.AddPlan(1.2, run.keyframes[0].path_map, run.keyframes[0].view);
  writer.Save(folder_ / "run.bin");
  const RunRecording early = LoadRecording(folder_ / "run.bin");
  ASSERT_EQ(early.states.size(), 15u);
  ASSERT_EQ(early.keyframes.size(), 2u);
  EXPECT_TRUE(early.keyframes[0].path_map.empty());
  EXPECT_EQ(early.keyframes[1].path_map, run.keyframes[0].path_map);
  EXPECT_EQ(early.keyframes[1].occupied_map, early.keyframes[0].occupied_map);

  for (int i = 15; i <= 40; ++i) writer.AddState(run.states[static_cast<size_t>(i)]);
  writer.AddMap(3.0, run.keyframes[1].occupied_map);
  writer.Save(folder_ / "run.bin");
  RunRecording whole = run;
  whole.keyframes = {{1.0, map, {}, std::nullopt},
                     {1.2, map, run.keyframes[0].path_map, run.keyframes[0].view},
                     {3.0, run.keyframes[1].occupied_map, {}, std::nullopt}};
  SaveRecording(folder_ / "whole.bin", whole);
  EXPECT_EQ(core::ReadFile(folder_ / "run.bin"), core::ReadFile(folder_ / "whole.bin"));
}

TEST_F(VideoTest, RecordingCutShortAnywhereIsRefused) {
  SaveRecording(folder_ / "run.bin", ShortRun());
  const std::string whole = core::ReadFile(folder_ / "run.bin");
  for (size_t size = 0; size < whole.size(); size += 37) {
    core::WriteFileAtomically(folder_ / "cut.bin", whole.substr(0, size));
    EXPECT_THROW(LoadRecording(folder_ / "cut.bin"), core::InputError) << size;
  }
}

TEST_F(VideoTest, VoxelMeshHasExactlyTheExposedFaces) {
  core::Rng rng(1);
  std::set<std::array<int, 3>> cells;
  for (int i = 0; i < 400; ++i)
    cells.insert({rng.UniformInt(8) - 4, rng.UniformInt(8) - 4, rng.UniformInt(8) - 4});
  std::vector<core::Vec3f> centers;
  size_t exposed = 0;
  for (const auto& c : cells) {
    centers.push_back(0.05f * core::Vec3f(c[0] + 0.5f, c[1] + 0.5f, c[2] + 0.5f));
    for (size_t axis = 0; axis < 3; ++axis) {
      for (const int step : {-1, 1}) {
        auto neighbour = c;
        neighbour[axis] += step;
        exposed += cells.contains(neighbour) ? 0 : 1;
      }
    }
  }
  const sim::ColoredMesh mesh = VoxelMesh(centers, 0.05, -0.2, 0.2);
  EXPECT_EQ(mesh.mesh.triangles.size(), 2 * exposed);
  EXPECT_NEAR(mesh.mesh.AreaM2(), static_cast<double>(exposed) * 0.0025, 1e-4);
  // Closed and facing outwards: the divergence theorem gives the volume.
  double volume = 0.0;
  for (const auto& t : mesh.mesh.triangles) {
    const auto& v = mesh.mesh.vertices;
    volume += v[t[0]].cast<double>().dot(v[t[1]].cast<double>().cross(v[t[2]].cast<double>())) / 6.0;
  }
  EXPECT_NEAR(volume, static_cast<double>(cells.size()) * 0.05 * 0.05 * 0.05, 1e-6);
}

TEST_F(VideoTest, VideoHoldsEveryFrameAndNothingElseIsLeft) {
  VideoWriter writer(folder_ / "a" / "video.mp4", 64, 48, 25.0);
  for (uint8_t i = 0; i < 30; ++i)
    writer.Add({64, 48, std::vector<uint8_t>(64 * 48 * 3, static_cast<uint8_t>(8 * i))});
  EXPECT_FALSE(fs::exists(folder_ / "a" / "video.mp4"));
  writer.Finish();
  const std::string probe =
      OutputOf("ffprobe -v error -show_entries stream=codec_name,pix_fmt,nb_frames -of csv=p=0 " +
               (folder_ / "a" / "video.mp4").string());
  EXPECT_EQ(probe, "h264,yuv420p,30\n");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "a"), fs::directory_iterator{}), 1);
}

TEST_F(VideoTest, AbandonedVideoLeavesNoFile) {
  {
    VideoWriter writer(folder_ / "video.mp4", 64, 48, 25.0);
    writer.Add({64, 48, std::vector<uint8_t>(64 * 48 * 3)});
  }
  EXPECT_EQ(FilesInFolder(), 0u);
}

TEST_F(VideoTest, NamesAreFilesWhateverTheyLookLike) {
  const fs::path before = fs::current_path();
  fs::current_path(folder_);
  const sim::RgbImage frame{16, 16, std::vector<uint8_t>(16 * 16 * 3, 99)};
  const std::vector<std::string> names = {"-y.mp4",         "pipe:1",   "http:x.mp4",
                                          "concat:a|b.mp4", "%03d.mp4", "a b.mp4"};
  for (const std::string& name : names) {
    VideoWriter writer(name, 16, 16, 25.0);
    writer.Add(frame);
    writer.Finish();
    WritePng(name + ".png", frame);
    EXPECT_TRUE(core::ReadFile(name).substr(4).starts_with("ftyp")) << name;
    EXPECT_TRUE(core::ReadFile(name + ".png").substr(1).starts_with("PNG")) << name;
  }
  fs::current_path(before);
  EXPECT_EQ(FilesInFolder(), 2 * names.size());
}

TEST_F(VideoTest, LinksPlantedAtItsNamesAreNotFollowed) {
  core::WriteFileAtomically(folder_ / "victim", "untouched");
  const std::string process = std::to_string(::getpid());
  fs::create_symlink(folder_ / "victim", folder_ / ("video.mp4.tmp" + process));
  fs::create_symlink(folder_ / "victim", folder_ / "video.mp4");
  VideoWriter writer(folder_ / "video.mp4", 16, 16, 25.0);
  writer.Add({16, 16, std::vector<uint8_t>(16 * 16 * 3)});
  writer.Finish();
  EXPECT_EQ(core::ReadFile(folder_ / "victim"), "untouched");
  EXPECT_FALSE(fs::is_symlink(folder_ / "video.mp4"));
}

TEST_F(VideoTest, AVideoThatDoesNotFitIsAnErrorAndLeavesNothing) {
  rlimit before;
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit limit{200, before.rlim_max};
  const auto handler = signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &limit);
  EXPECT_THROW(
      {
        VideoWriter writer(folder_ / "video.mp4", 64, 48, 25.0);
        for (uint8_t i = 0; i < 30; ++i)
          writer.Add({64, 48, std::vector<uint8_t>(64 * 48 * 3, static_cast<uint8_t>(8 * i))});
        writer.Finish();
      },
      core::InputError);
  setrlimit(RLIMIT_FSIZE, &before);
  signal(SIGXFSZ, handler);
  EXPECT_EQ(FilesInFolder(), 0u);
}

TEST_F(VideoTest, FfmpegsRefusalIsAnInputError) {
  core::WriteFileAtomically(folder_ / "file", "not a folder");
  EXPECT_THROW(WritePng(folder_ / "file" / "picture.png", {2, 2, std::vector<uint8_t>(12)}),
               core::InputError);
}

TEST_F(VideoTest, PictureIsLossless) {
  sim::RgbImage image{16, 8, {}};
  core::Rng rng(2);
  for (int i = 0; i < 16 * 8 * 3; ++i) image.rgb.push_back(static_cast<uint8_t>(rng.UniformInt(256)));
  WritePng(folder_ / "picture.png", image);
  const std::string raw =
      OutputOf("ffmpeg -v error -i " + (folder_ / "picture.png").string() + " -f rawvideo -pix_fmt rgb24 -");
  EXPECT_EQ(raw, std::string(image.rgb.begin(), image.rgb.end()));
}

TEST_F(VideoTest, FramesCoverTheRunAndShowTheMapWhenItCame) {
  const RunRecording run = ShortRun();
  const VideoParams params{.width = 160, .height = 90, .frames_per_second = 10.0, .speed = 1.0, .samples = 1};
  RunRecording blind = run;
  blind.keyframes.clear();
  RunVideo with(Floor(), robots::LoadRobot("quadruped"), run, params);
  RunVideo without(Floor(), robots::LoadRobot("quadruped"), blind, params);
  ASSERT_EQ(with.frames(), 41);
  for (int frame = 0; frame < 20; frame += 3) {
    const bool equal = with.Frame(frame).rgb == without.Frame(frame).rgb;
    EXPECT_EQ(equal, frame < 10) << frame;
  }
}

TEST_F(VideoTest, FigureStandsWhereItsStateSays) {
  sim::RobotFigure figure(robots::LoadRobot("quadruped"));
  ASSERT_EQ(figure.qpos_size(), 19u);
  const std::vector<core::Pose> poses = figure.PosesOf(StandingAt(3.0, -2.0));
  ASSERT_EQ(poses.size(), figure.bodies().size());
  EXPECT_LT((poses[0].translation() - core::Vec3(3.0, -2.0, 0.5)).norm(), 1e-9);
  core::Box3 extent;
  for (size_t i = 0; i < poses.size(); ++i) {
    core::TriMesh mesh = figure.bodies()[i].mesh;
    mesh.Transform(poses[i]);
    const core::Box3 bounds = mesh.Bounds();
    extent.Extend(bounds.min);
    extent.Extend(bounds.max);
  }
  EXPECT_GT(extent.Size().z(), 0.4);
  EXPECT_LT(extent.Size().maxCoeff(), 1.6);
}

TEST_F(VideoTest, RecordingOfAnotherRobotIsRefused) {
  RunRecording run = ShortRun();
  run.states[3].qpos.pop_back();
  EXPECT_THROW(RunVideo(Floor(), robots::LoadRobot("quadruped"), run, {}), core::InputError);
}

}  // namespace
}  // namespace atlas::experiments
