#include "sim/render/robot_figure.h"

#include <mujoco/mujoco.h>

#include <cassert>

#include "core/errors.h"
#include "sim/world/mujoco_guard.h"
#include "sim/world/robot_meshes.h"

namespace atlas::sim {
namespace {

constexpr int kVisibleGroup = 2;

Rgb ColorOf(const mjModel& model, int geom) {
  const int material = model.geom_matid[geom];
  const float* rgba = material >= 0 ? model.mat_rgba + 4 * material : model.geom_rgba + 4 * geom;
  Rgb rgb;
  for (size_t i = 0; i < 3; ++i) rgb[i] = static_cast<uint8_t>(std::clamp(rgba[i], 0.0f, 1.0f) * 255.0f);
  return rgb;
}

/// Feet are collision spheres in models whose legs show nothing there.
bool IsShown(const mjModel& model, int geom) {
  return model.geom_group[geom] == kVisibleGroup || model.geom_type[geom] == mjGEOM_SPHERE;
}

ColoredMesh FigureOf(const mjModel& model, int body) {
  ColoredMesh figure;
  const int first = model.body_geomadr[body];
  for (int g = first; g < first + model.body_geomnum[body]; ++g) {
    if (!IsShown(model, g)) continue;
    const core::TriMesh mesh = GeomMesh(model, g);
    figure.mesh.Append(mesh);
    figure.rgb.insert(figure.rgb.end(), mesh.triangles.size(), ColorOf(model, g));
  }
  return figure;
}

}  // namespace

struct RobotFigure::Impl {
  mjModel* model = nullptr;
  mjData* data = nullptr;
  std::vector<ColoredMesh> figures;
  std::vector<int> body_of_figure;

  ~Impl() {
    mj_deleteData(data);
    mj_deleteModel(model);
  }
};

RobotFigure::RobotFigure(const robots::RobotSpec& robot) : impl_(std::make_unique<Impl>()) {
  InstallMujocoHandlers();
  char error[512] = "";
  impl_->model = mj_loadXML(robot.mjcf.c_str(), nullptr, error, sizeof error);
  if (impl_->model == nullptr) throw core::InputError(robot.mjcf.string() + ": " + error);
  impl_->data = mj_makeData(impl_->model);
  for (int body = 1; body < impl_->model->nbody; ++body) {
    ColoredMesh figure = FigureOf(*impl_->model, body);
    if (figure.mesh.triangles.empty()) continue;
    impl_->figures.push_back(std::move(figure));
    impl_->body_of_figure.push_back(body);
  }
}

RobotFigure::~RobotFigure() = default;

const std::vector<ColoredMesh>& RobotFigure::bodies() const {
  return impl_->figures;
}
size_t RobotFigure::qpos_size() const {
  return static_cast<size_t>(impl_->model->nq);
}

std::vector<core::Pose> RobotFigure::PosesOf(std::span<const double> qpos) {
  assert(qpos.size() == qpos_size());
  mju_copy(impl_->data->qpos, qpos.data(), impl_->model->nq);
  mj_kinematics(impl_->model, impl_->data);
  std::vector<core::Pose> poses;
  for (const int body : impl_->body_of_figure) {
    const mjtNum* q = impl_->data->xquat + 4 * body;
    poses.push_back(core::MakePose(Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix(),
                                   Eigen::Map<const core::Vec3>(impl_->data->xpos + 3 * body)));
  }
  return poses;
}

}  // namespace atlas::sim
