// Shapes with closed forms: signed distance (negative inside), and where a ray first meets them.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/geometry.h"

namespace atlas::tests {

class AnalyticShape {
 public:
  virtual ~AnalyticShape() = default;
  virtual double Distance(const core::Vec3& p) const = 0;
  /// @pre direction is unit; origin is outside.
  virtual std::optional<double> Cast(const core::Vec3& origin, const core::Vec3& direction) const = 0;
  /// The direction to free space at a point near the surface.
  core::Vec3 Normal(const core::Vec3& p) const {
    constexpr double kStep = 1e-5;
    core::Vec3 n;
    for (int a = 0; a < 3; ++a) {
      const core::Vec3 d = kStep * core::Vec3::Unit(a);
      n[a] = Distance(p + d) - Distance(p - d);
    }
    return n.normalized();
  }
};

class Sphere : public AnalyticShape {
 public:
  Sphere(const core::Vec3& center, double radius_m) : center_(center), radius_m_(radius_m) {}
  double Distance(const core::Vec3& p) const override { return (p - center_).norm() - radius_m_; }
  std::optional<double> Cast(const core::Vec3& origin, const core::Vec3& direction) const override {
    const core::Vec3 to = origin - center_;
    const double b = to.dot(direction), c = to.squaredNorm() - radius_m_ * radius_m_, root = b * b - c;
    if (root < 0.0 || -b - std::sqrt(root) < 0.0) return std::nullopt;
    return -b - std::sqrt(root);
  }

 private:
  core::Vec3 center_;
  double radius_m_;
};

/// The half-space under a plane through `point`.
class HalfSpace : public AnalyticShape {
 public:
  HalfSpace(const core::Vec3& point, const core::Vec3& normal)
      : point_(point), normal_(normal.normalized()) {}
  double Distance(const core::Vec3& p) const override { return normal_.dot(p - point_); }
  std::optional<double> Cast(const core::Vec3& origin, const core::Vec3& direction) const override {
    const double speed = normal_.dot(direction);
    if (speed > -1e-9) return std::nullopt;
    return -Distance(origin) / speed;
  }

 private:
  core::Vec3 point_, normal_;
};

/// A box of half sides `half`, turned by `R_map_box` about its centre.
class SolidBox : public AnalyticShape {
 public:
  SolidBox(const core::Vec3& center, const core::Vec3& half,
           const core::Mat3& R_map_box = core::Mat3::Identity())
      : center_(center), half_(half), R_map_box_(R_map_box) {}
  double Distance(const core::Vec3& p) const override {
    const core::Vec3 q = (R_map_box_.transpose() * (p - center_)).cwiseAbs() - half_;
    return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
  }
  std::optional<double> Cast(const core::Vec3& origin, const core::Vec3& direction) const override {
    const core::Box3 box{-half_, half_};
    const auto inside =
        box.Clip(R_map_box_.transpose() * (origin - center_), R_map_box_.transpose() * direction);
    if (!inside) return std::nullopt;
    return inside->first;
  }

 private:
  core::Vec3 center_, half_;
  core::Mat3 R_map_box_;
};

/// About the z axis through `center`. No rays.
class Torus : public AnalyticShape {
 public:
  Torus(const core::Vec3& center, double ring_m, double tube_m)
      : center_(center), ring_m_(ring_m), tube_m_(tube_m) {}
  double Distance(const core::Vec3& p) const override {
    const core::Vec3 q = p - center_;
    return std::hypot(std::hypot(q.x(), q.y()) - ring_m_, q.z()) - tube_m_;
  }
  std::optional<double> Cast(const core::Vec3&, const core::Vec3&) const override { return std::nullopt; }

 private:
  core::Vec3 center_;
  double ring_m_, tube_m_;
};

}  // namespace atlas::tests
