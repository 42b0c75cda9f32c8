// One memory for what is never needed at the same time.
//
//                  project and bin           match             planes, tables
//      RayBundle   [written.................. read]            x, y, z   -> nx, ny, nz of the surface
//      RayBins     [written.................. read]            u, v, range, du, dv -> five of the tables
//
// Rays and bins are gone once cells have chosen; only then are surface and tables written. So the first two
// borrow eight vectors of the last two, and a scan touches a third less memory.
#pragma once

#include "mapping/integrator/free_space/free_space_tables.h"

namespace atlas::mapping {

/// Lends the memory while it lives. @pre nobody reads the surface or the tables meanwhile.
class MemoryLoan {
 public:
  MemoryLoan(size_t rays, SurfaceImage* surface, FreeSpaceTables* tables, RayBundle* bundle, RayBins* bins);
  ~MemoryLoan();
  MemoryLoan(const MemoryLoan&) = delete;
  MemoryLoan& operator=(const MemoryLoan&) = delete;

 private:
  static constexpr size_t kShared = 8;
  size_t room_;
  std::array<std::vector<float>*, kShared> lenders_, borrowers_;
};

}  // namespace atlas::mapping
