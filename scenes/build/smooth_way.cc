#include "scenes/build/smooth_way.h"

#include <cassert>

namespace atlas::scenes {
namespace {

using core::Vec3;

/// Between b and c by Barry and Goldman's pyramid with centripetal knots, u in [0, 1].
Vec3 CatmullRom(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, double u) {
  const double t0 = 0.0, t1 = t0 + std::sqrt((b - a).norm()), t2 = t1 + std::sqrt((c - b).norm()),
               t3 = t2 + std::sqrt((d - c).norm()), t = t1 + u * (t2 - t1);
  const auto mix = [t](const Vec3& p, const Vec3& q, double tp, double tq) -> Vec3 {
    return ((tq - t) * p + (t - tp) * q) / (tq - tp);
  };
  const Vec3 ab = mix(a, b, t0, t1), bc = mix(b, c, t1, t2), cd = mix(c, d, t2, t3);
  return mix(mix(ab, bc, t0, t2), mix(bc, cd, t1, t3), t1, t2);
}

}  // namespace

std::vector<Vec3> SmoothWay(const std::vector<Vec3>& way, double spacing_m) {
  assert(way.size() >= 2);
  const bool closed = way.size() > 3 && (way.front() - way.back()).norm() < 1e-9;
  std::vector<Vec3> curve;
  for (size_t i = 0; i + 1 < way.size(); ++i) {
    const Vec3 &b = way[i], &c = way[i + 1];
    const Vec3 a = i > 0 ? way[i - 1] : closed ? way[way.size() - 2] : Vec3(2.0 * b - c);
    const Vec3 d = i + 2 < way.size() ? way[i + 2] : closed ? way[1] : Vec3(2.0 * c - b);
    const int steps = std::max(1, static_cast<int>(std::ceil((c - b).norm() / spacing_m)));
    for (int k = 0; k < steps; ++k) curve.push_back(CatmullRom(a, b, c, d, static_cast<double>(k) / steps));
  }
  curve.push_back(way.back());
  return curve;
}

}  // namespace atlas::scenes
