#include "scenes/build/openings.h"

#include <algorithm>
#include <utility>

namespace atlas::scenes {
namespace {

/// The solid intervals along y of the column [x0, x1].
std::vector<std::pair<double, double>> SolidIntervals(const Rect& outer, const std::vector<Rect>& holes,
                                                      double x0, double x1) {
  std::vector<std::pair<double, double>> cut;
  for (const Rect& hole : holes) {
    if (hole.min.x() < x1 && hole.max.x() > x0) cut.emplace_back(hole.min.y(), hole.max.y());
  }
  std::sort(cut.begin(), cut.end());
  std::vector<std::pair<double, double>> solid;
  double y = outer.min.y();
  for (const auto& [low, high] : cut) {
    if (low > y) solid.emplace_back(y, low);
    y = high;
  }
  if (y < outer.max.y()) solid.emplace_back(y, outer.max.y());
  return solid;
}

}  // namespace

std::vector<Rect> CoverAround(const Rect& outer, const std::vector<Rect>& holes) {
  std::vector<double> xs = {outer.min.x(), outer.max.x()};
  for (const Rect& hole : holes) xs.insert(xs.end(), {hole.min.x(), hole.max.x()});
  std::sort(xs.begin(), xs.end());
  xs.erase(std::unique(xs.begin(), xs.end()), xs.end());

  std::vector<Rect> cover;
  std::vector<std::pair<double, double>> before;
  size_t first_of_before = 0;
  for (size_t k = 0; k + 1 < xs.size(); ++k) {
    const auto solid = SolidIntervals(outer, holes, xs[k], xs[k + 1]);
    if (k > 0 && solid == before) {
      for (size_t i = first_of_before; i < cover.size(); ++i) cover[i].max.x() = xs[k + 1];
      continue;
    }
    first_of_before = cover.size();
    before = solid;
    for (const auto& [low, high] : solid) cover.push_back({{xs[k], low}, {xs[k + 1], high}});
  }
  return cover;
}

}  // namespace atlas::scenes
