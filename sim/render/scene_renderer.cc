#include "sim/render/scene_renderer.h"

#include <cassert>

#include "sim/render/gl_api.h"
#include "sim/render/gpu_mesh.h"
#include "sim/render/render_target.h"
#include "sim/render/shaders.h"

namespace atlas::sim {
namespace {

constexpr int kShadowMapSize = 2048;
constexpr float kHazePerM = 0.004f;

/// OpenGL's camera looks along -z with y up.
Eigen::Matrix4d ClipFromMap(const RenderCamera& camera, double aspect) {
  const double f = 1.0 / std::tan(0.5 * camera.vertical_fov_rad), n = camera.near_m, far = camera.far_m;
  Eigen::Matrix4d P = Eigen::Matrix4d::Zero();
  P(0, 0) = f / aspect;
  P(1, 1) = f;
  P(2, 2) = -(far + n) / (far - n);
  P(2, 3) = -2.0 * far * n / (far - n);
  P(3, 2) = -1.0;
  return P * Eigen::Vector4d(1.0, -1.0, -1.0, 1.0).asDiagonal() * camera.T_map_camera.inverse().matrix();
}

/// The shadow ball, seen along the sun's rays, fills the clip cube.
Eigen::Matrix4d ShadowFromMap(const RenderLight& light) {
  const core::Vec3 z = light.to_sun.normalized();
  const core::Vec3 x = z.unitOrthogonal();
  core::Mat3 R_light_map;
  R_light_map << x.transpose(), z.cross(x).transpose(), -z.transpose();
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  T.topLeftCorner<3, 3>() = R_light_map / light.shadow_radius_m;
  T.topRightCorner<3, 1>() = -R_light_map * light.shadow_center / light.shadow_radius_m;
  return T;
}

}  // namespace

core::Pose LookAt(const core::Vec3& eye, const core::Vec3& target) {
  const core::Vec3 forward = (target - eye).normalized();
  const core::Vec3 right = forward.cross(core::Vec3::UnitZ()).normalized();
  core::Mat3 R;
  R << right, forward.cross(right), forward;
  return core::MakePose(R, eye);
}

struct SceneRenderer::Impl {
  struct Item {
    std::unique_ptr<GpuMesh> mesh;
    core::Pose T_map_mesh = core::Pose::Identity();
    bool visible = true;
  };

  std::shared_ptr<RenderContext> context;
  gl::Uint depth_program = 0, color_program = 0;
  std::vector<Item> items;
  std::unique_ptr<RenderTarget> target;
  std::unique_ptr<ShadowMap> shadow_map;

  const gl::Api& api() const { return context->api(); }
  void BindTarget(int width, int height, int samples) {
    if (!target || !target->Fits(width, height, samples)) {
      target = std::make_unique<RenderTarget>(api(), width, height, samples);
    }
    target->Bind();
  }
  int Location(gl::Uint program, const char* name) const { return api().GetUniformLocation(program, name); }
  void SetMatrix(int location, const Eigen::Matrix4d& T) const {
    const Eigen::Matrix4f value = T.cast<float>();
    api().UniformMatrix4fv(location, 1, 0, value.data());
  }
  void SetVector(int location, const core::Vec3& v) const {
    const core::Vec3f value = v.cast<float>();
    api().Uniform3fv(location, 1, value.data());
  }
  void DrawDepth(const Eigen::Matrix4d& T_clip_map) const;
  void DrawShadowMap(const Eigen::Matrix4d& T_shadow_map);
  void DrawColor(const RenderCamera& camera, const RenderLight& light, double aspect);
};

void SceneRenderer::Impl::DrawDepth(const Eigen::Matrix4d& T_clip_map) const {
  const gl::Api& gl = api();
  gl.UseProgram(depth_program);
  const int location = Location(depth_program, "T_clip_mesh");
  for (const Item& item : items) {
    if (!item.visible) continue;
    const Eigen::Matrix4d T_clip_mesh = T_clip_map * item.T_map_mesh.matrix();
    SetMatrix(location, T_clip_mesh);
    item.mesh->Draw(T_clip_mesh);
  }
}

void SceneRenderer::Impl::DrawShadowMap(const Eigen::Matrix4d& T_shadow_map) {
  const gl::Api& gl = api();
  if (!shadow_map) shadow_map = std::make_unique<ShadowMap>(gl, kShadowMapSize);
  shadow_map->Bind();
  gl.Clear(gl::kDepthBufferBit);
  // Pushes casters away from the sun so that lit faces do not shade themselves.
  gl.Enable(gl::kPolygonOffsetFill);
  gl.PolygonOffset(2.5f, 4.0f);
  DrawDepth(T_shadow_map);
  gl.Disable(gl::kPolygonOffsetFill);
}

void SceneRenderer::Impl::DrawColor(const RenderCamera& camera, const RenderLight& light, double aspect) {
  const gl::Api& gl = api();
  const gl::Uint program = color_program;
  const Eigen::Matrix4d T_clip_map = ClipFromMap(camera, aspect);
  const core::Vec3 sky = core::Vec3(light.sky[0], light.sky[1], light.sky[2]) / 255.0;
  const bool shadow = light.shadow_radius_m > 0.0;
  gl.UseProgram(program);
  SetVector(Location(program, "to_sun"), light.to_sun.normalized());
  SetVector(Location(program, "eye"), camera.T_map_camera.translation());
  SetVector(Location(program, "sky"), sky);
  gl.Uniform1f(Location(program, "haze_per_m"), kHazePerM);
  gl.Uniform1i(Location(program, "has_shadow"), shadow ? 1 : 0);
  gl.Uniform1i(Location(program, "shadow_map"), 0);
  gl.ActiveTexture(gl::kTexture0);
  gl.BindTexture(gl::kTexture2D, shadow ? shadow_map->texture() : 0);
  if (shadow) SetMatrix(Location(program, "T_shadow_map"), ShadowFromMap(light));
  gl.ClearColor(static_cast<float>(sky.x()), static_cast<float>(sky.y()), static_cast<float>(sky.z()), 1.0f);
  gl.Clear(gl::kColorBufferBit | gl::kDepthBufferBit);
  const int clip_location = Location(program, "T_clip_mesh"), map_location = Location(program, "T_map_mesh");
  for (const Item& item : items) {
    if (!item.visible) continue;
    const Eigen::Matrix4d T_clip_mesh = T_clip_map * item.T_map_mesh.matrix();
    SetMatrix(clip_location, T_clip_mesh);
    SetMatrix(map_location, item.T_map_mesh.matrix());
    item.mesh->Draw(T_clip_mesh);
  }
}

SceneRenderer::SceneRenderer(std::shared_ptr<RenderContext> context) : impl_(std::make_unique<Impl>()) {
  assert(context != nullptr);
  impl_->context = std::move(context);
  const RenderContext::Scope scope(*impl_->context);
  const gl::Api& gl = impl_->api();
  impl_->depth_program = gl::MakeProgram(gl, shaders::kDepthVertex, shaders::kDepthFragment);
  impl_->color_program = gl::MakeProgram(gl, shaders::kColorVertex, shaders::kColorFragment);
  gl.Enable(gl::kDepthTest);
  gl.DepthFunc(gl::kLess);
}

SceneRenderer::~SceneRenderer() {
  const RenderContext::Scope scope(*impl_->context);
  impl_->items.clear();
  impl_->target.reset();
  impl_->shadow_map.reset();
  impl_->api().DeleteProgram(impl_->depth_program);
  impl_->api().DeleteProgram(impl_->color_program);
}

int SceneRenderer::AddMesh(const ColoredMesh& mesh) {
  const RenderContext::Scope scope(*impl_->context);
  impl_->items.push_back({std::make_unique<GpuMesh>(impl_->api(), mesh)});
  return static_cast<int>(impl_->items.size()) - 1;
}

void SceneRenderer::ReplaceMesh(int id, const ColoredMesh& mesh) {
  const RenderContext::Scope scope(*impl_->context);
  impl_->items.at(static_cast<size_t>(id)).mesh = std::make_unique<GpuMesh>(impl_->api(), mesh);
}

void SceneRenderer::SetPose(int id, const core::Pose& T_map_mesh) {
  impl_->items.at(static_cast<size_t>(id)).T_map_mesh = T_map_mesh;
}

void SceneRenderer::SetVisible(int id, bool visible) {
  impl_->items.at(static_cast<size_t>(id)).visible = visible;
}

RgbImage SceneRenderer::RenderRgb(const RenderCamera& camera, const RenderLight& light, int width, int height,
                                  int samples) {
  const RenderContext::Scope scope(*impl_->context);
  if (light.shadow_radius_m > 0.0) impl_->DrawShadowMap(ShadowFromMap(light));
  impl_->BindTarget(width, height, samples);
  impl_->DrawColor(camera, light, static_cast<double>(width) / height);
  return impl_->target->ReadRgb();
}

std::vector<float> SceneRenderer::RenderDepth(const RenderCamera& camera, int width, int height) {
  const RenderContext::Scope scope(*impl_->context);
  const gl::Api& gl = impl_->api();
  impl_->BindTarget(width, height, 1);
  gl.ColorMask(0, 0, 0, 0);
  gl.Clear(gl::kDepthBufferBit);
  impl_->DrawDepth(ClipFromMap(camera, static_cast<double>(width) / height));
  gl.ColorMask(1, 1, 1, 1);
  std::vector<float> depth = impl_->target->ReadDepth();
  const auto n = static_cast<float>(camera.near_m), f = static_cast<float>(camera.far_m);
  for (float& d : depth) {
    d = d < 1.0f ? n * f / (f - d * (f - n)) : std::numeric_limits<float>::infinity();
  }
  return depth;
}

const RenderContext& SceneRenderer::context() const {
  return *impl_->context;
}

}  // namespace atlas::sim
