#include "sim/sensors/depth_camera.h"

#include <cassert>

#include "sim/render/scene_renderer.h"

namespace atlas::sim {
namespace {

/// The clip planes stand off the sensor's limits, so that the limits are applied to metres, not to clipping.
constexpr double kNearShare = 0.25;
constexpr double kFarMarginM = 0.05;
constexpr float kBodyMarginM = 0.02f;

/// Colours do not matter to depth.
ColoredMesh Plain(const core::TriMesh& mesh) {
  return {mesh, {Rgb{255, 255, 255}}};
}

}  // namespace

struct DepthCamera::Impl {
  DepthCameraModel model;
  uint64_t noise_seed = 0;
  uint64_t captures = 0;
  std::string why_unavailable;
  std::unique_ptr<SceneRenderer> renderer;
  int first_body = 0;  ///< bodies follow the scene among the renderer's meshes
  int bodies = 0;

  void MaskBodies(const RenderCamera& camera, std::vector<float>* depth_m);
};

/// What the bodies alone would show at the depth that was seen is the robot itself.
void DepthCamera::Impl::MaskBodies(const RenderCamera& camera, std::vector<float>* depth_m) {
  if (bodies == 0) return;
  const int scene = first_body - 1;
  renderer->SetVisible(scene, false);
  const std::vector<float> own_m = renderer->RenderDepth(camera, model.width, model.height);
  renderer->SetVisible(scene, true);
  for (size_t i = 0; i < own_m.size(); ++i) {
    if (own_m[i] <= (*depth_m)[i] + kBodyMarginM) (*depth_m)[i] = std::numeric_limits<float>::quiet_NaN();
  }
}

DepthCamera::DepthCamera(const scenes::SceneSpec& scene, const DepthCameraModel& model, const core::Rng& rng)
    : impl_(std::make_unique<Impl>()) {
  impl_->model = model;
  impl_->noise_seed = rng.Split("depth_camera").seed();
  RenderContext::Made made = RenderContext::Make();
  if (!made.context) {
    impl_->why_unavailable = made.why_not;
    return;
  }
  impl_->renderer = std::make_unique<SceneRenderer>(std::move(made.context));
  core::TriMesh all;
  for (const scenes::ScenePart& part : scene.parts) all.Append(part.mesh);
  impl_->first_body = impl_->renderer->AddMesh(Plain(all)) + 1;
}

DepthCamera::~DepthCamera() = default;
DepthCamera::DepthCamera(DepthCamera&&) noexcept = default;

bool DepthCamera::available() const {
  return impl_->renderer != nullptr;
}
std::string DepthCamera::backend() const {
  return available() ? impl_->renderer->context().backend() : std::string("none");
}
std::string DepthCamera::why_unavailable() const {
  return impl_->why_unavailable;
}

int DepthCamera::AddBody(const core::TriMesh& mesh_body) {
  if (available()) impl_->renderer->AddMesh(Plain(mesh_body));
  return impl_->bodies++;
}

void DepthCamera::SetBodyPose(int body, const core::Pose& T_map_body) {
  assert(body >= 0 && body < impl_->bodies);
  if (available()) impl_->renderer->SetPose(impl_->first_body + body, T_map_body);
}

core::DepthImage DepthCamera::Capture(const core::Pose& T_map_camera) {
  assert(available());
  const DepthCameraModel& model = impl_->model;
  core::DepthImage image;
  image.width = model.width;
  image.height = model.height;
  image.focal_px = 0.5 * model.width / std::tan(0.5 * model.hfov_rad);
  RenderCamera camera;
  camera.T_map_camera = T_map_camera;
  camera.vertical_fov_rad = 2.0 * std::atan(0.5 * model.height / image.focal_px);
  camera.near_m = kNearShare * model.min_depth_m;
  camera.far_m = model.max_depth_m + kFarMarginM;
  image.depth_m = impl_->renderer->RenderDepth(camera, model.width, model.height);
  impl_->MaskBodies(camera, &image.depth_m);

  const uint64_t seed = core::HashCounter(impl_->noise_seed, impl_->captures++);
  for (size_t i = 0; i < image.depth_m.size(); ++i) {
    float& z = image.depth_m[i];
    if (!(z >= model.min_depth_m && z <= model.max_depth_m)) {
      z = std::numeric_limits<float>::quiet_NaN();
    } else if (model.sigma_per_m2 > 0.0) {
      z += static_cast<float>(model.sigma_per_m2 * z * z * core::NormalAt(seed, i));
    }
  }
  return image;
}

}  // namespace atlas::sim
