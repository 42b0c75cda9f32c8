#include "sim/world/static_geometry.h"

#include <mujoco/mujoco.h>

namespace atlas::sim {
namespace {

using core::Box3;
using core::Mat3;
using core::Vec3;

Box3 LocalBox(const mjModel& m, int g) {
  const mjtNum* size = m.geom_size + 3 * g;
  Box3 box;
  const auto symmetric = [&](double x, double y, double z) { box = {Vec3(-x, -y, -z), Vec3(x, y, z)}; };
  switch (m.geom_type[g]) {
    case mjGEOM_SPHERE:
      symmetric(size[0], size[0], size[0]);
      break;
    case mjGEOM_CAPSULE:
      symmetric(size[0], size[0], size[0] + size[1]);
      break;
    case mjGEOM_CYLINDER:
      symmetric(size[0], size[0], size[1]);
      break;
    case mjGEOM_HFIELD: {
      const mjtNum* s = m.hfield_size + 4 * m.geom_dataid[g];
      box = {Vec3(-s[0], -s[1], -s[3]), Vec3(s[0], s[1], s[2])};
      break;
    }
    case mjGEOM_MESH: {
      const int mesh = m.geom_dataid[g];
      for (int v = 0; v < m.mesh_vertnum[mesh]; ++v) {
        const float* p = m.mesh_vert + 3 * (m.mesh_vertadr[mesh] + v);
        box.Extend(Vec3(p[0], p[1], p[2]));
      }
      break;
    }
    default:
      symmetric(size[0], size[1], size[2]);
      break;
  }
  return box;
}

Box3 WorldBox(const mjModel& m, const mjData& d, int g) {
  const Box3 local = LocalBox(m, g);
  const Mat3 R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(d.geom_xmat + 9 * g);
  const Vec3 middle = Eigen::Map<const Vec3>(d.geom_xpos + 3 * g) + R * local.Center();
  const Vec3 half = R.cwiseAbs() * (0.5 * local.Size());
  return {middle - half, middle + half};
}

}  // namespace

StaticGeometry::StaticGeometry(mjModel_* model, const mjData_* data) : model_(model), data_(data) {
  Box3 all;
  for (int g = 0; g < model->ngeom; ++g) {
    if (model->body_weldid[model->geom_bodyid[g]] != 0) continue;
    shapes_.push_back({g, WorldBox(*model, *data, g)});
    all.Extend(shapes_.back().box.min);
    all.Extend(shapes_.back().box.max);
  }
  if (shapes_.empty()) return;
  constexpr double kCellsAcross = 256.0;
  origin_ = all.min.head<2>();
  cell_m_ = std::max(1.0, all.Size().head<2>().maxCoeff() / kCellsAcross);
  cols_ = static_cast<int>(all.Size().x() / cell_m_) + 1;
  rows_ = static_cast<int>(all.Size().y() / cell_m_) + 1;
  cells_.resize(static_cast<size_t>(cols_) * static_cast<size_t>(rows_));
  for (size_t i = 0; i < shapes_.size(); ++i) {
    const auto at = [&](double value, int axis) {
      return static_cast<int>((value - origin_[axis]) / cell_m_);
    };
    const Box3& box = shapes_[i].box;
    for (int r = at(box.min.y(), 1); r <= std::min(at(box.max.y(), 1), rows_ - 1); ++r) {
      for (int c = at(box.min.x(), 0); c <= std::min(at(box.max.x(), 0), cols_ - 1); ++c) {
        cells_[static_cast<size_t>(r) * static_cast<size_t>(cols_) + static_cast<size_t>(c)].push_back(
            static_cast<int>(i));
      }
    }
  }
}

void StaticGeometry::Activate(const Box3& near) {
  for (const Shape& shape : shapes_) {
    const bool meets = (shape.box.min.array() <= near.max.array()).all() &&
                       (shape.box.max.array() >= near.min.array()).all();
    model_->geom_contype[shape.geom] = meets ? 2 : 0;
    model_->geom_conaffinity[shape.geom] = meets ? 1 : 0;
  }
}

const std::vector<int>* StaticGeometry::Cell(double x, double y) const {
  const double c = std::floor((x - origin_.x()) / cell_m_), r = std::floor((y - origin_.y()) / cell_m_);
  if (!(c >= 0.0 && r >= 0.0 && c < cols_ && r < rows_)) return nullptr;
  return &cells_[static_cast<size_t>(r) * static_cast<size_t>(cols_) + static_cast<size_t>(c)];
}

double StaticGeometry::RayTo(const Shape& shape, const Vec3& p, double direction_z) const {
  const Vec3 down(0.0, 0.0, direction_z);
  const int g = shape.geom;
  switch (model_->geom_type[g]) {
    case mjGEOM_HFIELD:
      return mj_rayHfield(model_, data_, g, p.data(), down.data());
    case mjGEOM_MESH:
      return mj_rayMesh(model_, data_, g, p.data(), down.data());
    default:
      return mju_rayGeom(data_->geom_xpos + 3 * g, data_->geom_xmat + 9 * g, model_->geom_size + 3 * g,
                         p.data(), down.data(), model_->geom_type[g]);
  }
}

std::optional<double> StaticGeometry::Below(const Vec3& p) const {
  const std::vector<int>* cell = Cell(p.x(), p.y());
  std::optional<double> ground;
  if (cell == nullptr) return ground;
  for (const int i : *cell) {
    const Shape& shape = shapes_[static_cast<size_t>(i)];
    const Box3& box = shape.box;
    const bool over = p.x() >= box.min.x() && p.x() <= box.max.x() && p.y() >= box.min.y() &&
                      p.y() <= box.max.y() && p.z() >= box.min.z();
    if (!over || (ground && box.max.z() <= *ground)) continue;
    const double range = RayTo(shape, p, -1.0);
    if (range < 0.0) continue;
    const bool may_be_inside = p.z() < box.max.z() && model_->geom_type[shape.geom] != mjGEOM_HFIELD;
    const double z = may_be_inside && RayTo(shape, p, 1.0) >= 0.0 ? p.z() : p.z() - range;
    ground = ground ? std::max(*ground, z) : z;
  }
  return ground;
}

}  // namespace atlas::sim
