#include "experiments/video/run_video.h"

#include "core/errors.h"
#include "experiments/video/follow_camera.h"
#include "experiments/video/overlays.h"
#include "experiments/video/video_writer.h"
#include "sim/render/robot_figure.h"

namespace atlas::experiments {
namespace {

constexpr sim::Rgb kPathRgb = {250, 250, 250}, kViewRgb = {235, 70, 160}, kTrailRgb = {255, 140, 20};
constexpr double kPathRadiusM = 0.025, kTrailRadiusM = 0.018;
constexpr double kTrailSpacingM = 0.08;
constexpr double kPathSpacingM = 0.1;
constexpr double kVoxelsNearerM = 0.008;  ///< drawn, so that faces on a surface do not flicker with it
constexpr double kAboveGroundM = 0.06;    ///< lines lie this high
constexpr double kTrailAboveGroundM = 0.1;
constexpr double kStepUpM = 0.8;  ///< the ground is looked for from this far above the last point
constexpr double kShadowRadiusM = 14.0;

std::unique_ptr<sim::SceneRenderer> MakeRenderer() {
  sim::RenderContext::Made made = sim::RenderContext::Make();
  if (!made.context) throw core::InputError("video: no off-screen renderer (" + made.why_not + ")");
  return std::make_unique<sim::SceneRenderer>(std::move(made.context));
}

void AddScene(sim::SceneRenderer* renderer, const scenes::SceneSpec& scene) {
  sim::ColoredMesh all;
  for (const scenes::ScenePart& part : scene.parts) {
    all.mesh.Append(part.mesh);
    all.rgb.insert(all.rgb.end(), part.mesh.triangles.size(), core::InfoOf(part.label).rgb);
  }
  if (all.rgb.empty()) all.rgb.push_back({0, 0, 0});
  renderer->AddMesh(all);
}

core::Vec3 BaseOf(const sim::Snapshot& state) {
  return {state.qpos[0], state.qpos[1], state.qpos[2]};
}

}  // namespace

struct RunVideo::Impl {
  Impl(const scenes::SceneSpec& scene, const robots::RobotSpec& robot, const RunRecording& recording,
       const VideoParams& params)
      : scene(scene),
        robot(robot),
        recording(recording),
        params(params),
        renderer(MakeRenderer()),
        figure(robot),
        raycaster(scene),
        camera(scene, raycaster) {}

  void PoseRobot(const sim::Snapshot& state);
  void ShowKeyframe(const VideoKeyframe& keyframe, const core::Vec3& p_base);
  void ExtendTrail(size_t state_index);
  double GroundBelow(const core::Vec2& p, double from_z, double otherwise) const;
  std::vector<core::Vec3> OnGround(const std::vector<core::Vec2>& path, double ground_z) const;

  const scenes::SceneSpec scene;
  const robots::RobotSpec robot;
  const RunRecording& recording;
  const VideoParams params;
  std::unique_ptr<sim::SceneRenderer> renderer;
  sim::RobotFigure figure;
  sim::Raycaster raycaster;
  FollowCamera camera;
  int first_body = 0, voxels = 0, path = 0, view = 0, trail = 0;  ///< meshes of the renderer
  size_t state = 0, keyframes_shown = 0, trail_states = 0;
  std::vector<core::Vec3> trail_points;
};

void RunVideo::Impl::PoseRobot(const sim::Snapshot& now) {
  const std::vector<core::Pose> poses = figure.PosesOf(now.qpos);
  for (size_t i = 0; i < poses.size(); ++i) renderer->SetPose(first_body + static_cast<int>(i), poses[i]);
}

double RunVideo::Impl::GroundBelow(const core::Vec2& p, double from_z, double otherwise) const {
  const core::Ray ray{core::Vec3(p.x(), p.y(), from_z).cast<float>(), {0.0f, 0.0f, -1.0f}};
  sim::RayHit hit;
  raycaster.CastStatic({&ray, 1}, 5.0f, 1, {&hit, 1});
  return hit.range_m < 0.0f ? otherwise : from_z - hit.range_m;
}

/// The path at short spacing, each point on the ground near the one before (so that it keeps to its storey).
std::vector<core::Vec3> RunVideo::Impl::OnGround(const std::vector<core::Vec2>& waypoints,
                                                 double ground_z) const {
  std::vector<core::Vec3> points;
  for (size_t i = 0; i + 1 < waypoints.size(); ++i) {
    const double length = (waypoints[i + 1] - waypoints[i]).norm();
    const int pieces = std::max(1, static_cast<int>(length / kPathSpacingM));
    for (int k = i == 0 ? 0 : 1; k <= pieces; ++k) {
      const core::Vec2 p = waypoints[i] + (waypoints[i + 1] - waypoints[i]) * k / pieces;
      ground_z = GroundBelow(p, ground_z + kStepUpM, ground_z);
      points.emplace_back(p.x(), p.y(), ground_z + kAboveGroundM);
    }
  }
  return points;
}

void RunVideo::Impl::ShowKeyframe(const VideoKeyframe& keyframe, const core::Vec3& p_base) {
  const double low = scene.object_box.Empty() ? 0.0 : scene.object_box.min.z();
  const double high = scene.object_box.Empty() ? 3.0 : scene.object_box.max.z();
  renderer->ReplaceMesh(voxels, VoxelMesh(keyframe.occupied_map, recording.resolution_m, low, high));
  const double ground = p_base.z() - robot.stance_height_m;
  const std::vector<core::Vec3> points = OnGround(keyframe.path_map, ground);
  renderer->ReplaceMesh(path, TubeMesh(points, kPathRadiusM, kPathRgb));
  renderer->SetVisible(view, keyframe.view.has_value());
  if (!keyframe.view) return;
  const core::Vec2& p = keyframe.view->p_map;
  const double last = points.empty() ? ground : points.back().z() - kAboveGroundM;
  renderer->SetPose(view, core::PoseFromXyzYaw({p.x(), p.y(), GroundBelow(p, last + kStepUpM, last)},
                                               keyframe.view->yaw_rad));
}

void RunVideo::Impl::ExtendTrail(size_t state_index) {
  const size_t before = trail_points.size();
  for (; trail_states <= state_index; ++trail_states) {
    core::Vec3 p = BaseOf(recording.states[trail_states]);
    p.z() += kTrailAboveGroundM - robot.stance_height_m;
    if (trail_points.empty() || (p - trail_points.back()).head<2>().norm() > kTrailSpacingM) {
      trail_points.push_back(p);
    }
  }
  if (trail_points.size() != before)
    renderer->ReplaceMesh(trail, TubeMesh(trail_points, kTrailRadiusM, kTrailRgb));
}

RunVideo::RunVideo(const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                   const RunRecording& recording, const VideoParams& params)
    : impl_(std::make_unique<Impl>(scene, robot, recording, params)) {
  if (recording.states.empty()) throw core::InputError("video: the recording holds no states");
  for (const sim::Snapshot& state : recording.states) {
    if (state.qpos.size() != impl_->figure.qpos_size()) {
      throw core::InputError("video: the recording is of another robot than " + robot.name);
    }
  }
  AddScene(impl_->renderer.get(), scene);
  const sim::ColoredMesh nothing{{}, {kPathRgb}};
  impl_->voxels = impl_->renderer->AddMesh(nothing);
  impl_->path = impl_->renderer->AddMesh(nothing);
  impl_->trail = impl_->renderer->AddMesh(nothing);
  impl_->view = impl_->renderer->AddMesh(ViewMarkerMesh(kViewRgb));
  impl_->renderer->SetVisible(impl_->view, false);
  impl_->first_body = impl_->view + 1;
  for (const sim::ColoredMesh& body : impl_->figure.bodies()) impl_->renderer->AddMesh(body);
}

RunVideo::~RunVideo() = default;

int RunVideo::frames() const {
  const auto& states = impl_->recording.states;
  const double video_s = (states.back().time_s - states.front().time_s) / impl_->params.speed;
  return 1 + static_cast<int>(video_s * impl_->params.frames_per_second);
}

sim::RgbImage RunVideo::Frame(int frame) {
  Impl& m = *impl_;
  const auto& states = m.recording.states;
  const double dt_s = 1.0 / m.params.frames_per_second;
  const double time_s = states.front().time_s + frame * dt_s * m.params.speed;
  while (m.state + 1 < states.size() && states[m.state + 1].time_s <= time_s) ++m.state;
  const core::Vec3 p_base = BaseOf(states[m.state]);
  m.PoseRobot(states[m.state]);
  m.ExtendTrail(m.state);
  const auto& keyframes = m.recording.keyframes;
  const size_t shown = m.keyframes_shown;
  while (m.keyframes_shown < keyframes.size() && keyframes[m.keyframes_shown].time_s <= time_s)
    ++m.keyframes_shown;
  if (m.keyframes_shown != shown) m.ShowKeyframe(keyframes[m.keyframes_shown - 1], p_base);

  const sim::RenderCamera camera = m.params.camera.value_or(m.camera.Advance(p_base, dt_s));
  core::Pose T_map_voxels = core::Pose::Identity();
  T_map_voxels.translation() = -kVoxelsNearerM * camera.T_map_camera.linear().col(2);
  m.renderer->SetPose(m.voxels, T_map_voxels);
  sim::RenderLight light;
  light.shadow_center = p_base;
  light.shadow_radius_m = kShadowRadiusM;
  return m.renderer->RenderRgb(camera, light, m.params.width, m.params.height, m.params.samples);
}

void RequireVideoTools() {
  MakeRenderer();
  FfmpegPipe({"-version"}).Finish();
}

void WriteRunVideo(const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                   const RunRecording& recording, const VideoParams& params, const std::filesystem::path& mp4,
                   const std::function<void(double)>& progress) {
  RunVideo video(scene, robot, recording, params);
  VideoWriter writer(mp4, params.width, params.height, params.frames_per_second);
  const int frames = video.frames();
  for (int frame = 0; frame < frames; ++frame) {
    writer.Add(video.Frame(frame));
    progress(static_cast<double>(frame + 1) / frames);
  }
  writer.Finish();
}

sim::RgbImage RenderStill(const scenes::SceneSpec& scene, const sim::RenderCamera& camera, int width,
                          int height) {
  const std::unique_ptr<sim::SceneRenderer> renderer = MakeRenderer();
  AddScene(renderer.get(), scene);
  sim::RenderLight light;
  const core::Box3& box = scene.object_box;
  light.shadow_center = box.Empty() ? core::Vec3(0, 0, 0) : box.Center();
  light.shadow_radius_m = box.Empty() ? kShadowRadiusM : std::max(0.75 * box.Size().norm(), 6.0);
  return renderer->RenderRgb(camera, light, width, height, 4);
}

sim::RgbImage RenderScenePicture(const scenes::SceneSpec& scene, int width, int height) {
  const core::Box3& box = scene.object_box.Empty() ? scene.bounds : scene.object_box;
  const core::Vec3 center = box.Empty() ? core::Vec3(0, 0, 0) : box.Center();
  const double radius = box.Empty() ? 5.0 : 0.5 * box.Size().norm();
  sim::RenderCamera camera;
  camera.T_map_camera = sim::LookAt(center + radius * core::Vec3(1.2, -1.4, 0.9), center);
  camera.far_m = 20.0 * radius + 100.0;
  return RenderStill(scene, camera, width, height);
}

}  // namespace atlas::experiments
