#include "mapping/integrator/free_space/scan_memory.h"

#include <algorithm>
#include <utility>

namespace atlas::mapping {
namespace {

void GiveRoom(size_t room, std::vector<float>* to) {
  if (to->size() < room) to->resize(room);
}

}  // namespace

MemoryLoan::MemoryLoan(size_t rays, SurfaceImage* surface, FreeSpaceTables* tables, RayBundle* bundle,
                       RayBins* bins)
    : lenders_{&surface->nx,         &surface->ny,       &surface->nz,       &tables->own[0],
               &tables->surround[0], &tables->window[2], &tables->window[3], &tables->window[4]},
      borrowers_{&bundle->x, &bundle->y,     &bundle->z, &bundle->u,
                 &bundle->v, &bundle->range, &bins->du,  &bins->dv} {
  const GridColumns& grid = *tables->image;
  bins->pitch = static_cast<size_t>(grid.columns) + 2;
  bins->count = bins->pitch * static_cast<size_t>(grid.rows);
  bins->ray.resize(bins->count);
  bundle->count = rays;
  room_ = std::max(rays, bins->count);
  for (size_t i = 0; i < kShared; ++i) {
    std::swap(*lenders_[i], *borrowers_[i]);
    GiveRoom(room_, borrowers_[i]);
  }
}

MemoryLoan::~MemoryLoan() {
  for (size_t i = 0; i < kShared; ++i) std::swap(*lenders_[i], *borrowers_[i]);
}

}  // namespace atlas::mapping
