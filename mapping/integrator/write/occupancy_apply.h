// Adds a scan's evidence to stored log-odds, many voxels at a time.
#pragma once

#include <cstdint>

#include "mapping/octree/fields.h"

namespace atlas::mapping {

/// What became of the values that were updated.
struct ApplyResult {
  OccupancyField::Node node;
  int8_t min = 0;  ///< least value, unknown ones counting as 0
  bool changed = false;
};

/// Free voxels that lose `units` instead, where they hold more than `above`.
struct WeakMisses {
  const uint64_t* where = nullptr;  ///< a bit a value; null for none
  int units = 0, above = 0;
};

/// `layers` times 64 values. Where delta (may be null) is not 0, adds it; else where a bit of free (may be
/// null for all) is set, subtracts miss_units, or the units of `weak` in its voxels. Clamped; known evidence
/// that cancels is held as 1. A delta of hit_units or more is a return's: of what is positive the low bits
/// hold where in the voxel the surface lies (OccupancyField::kPlaces).
ApplyResult ApplyEvidence(int8_t* values, int layers, const uint64_t* free, const WeakMisses& weak,
                          const int8_t* delta, int miss_units, int hit_units);

/// Of the 4^3 octants of a block's 512 values, those whose voxels all equal kMin (saturated free). Bit x + 2
/// y + 4 z.
uint32_t SaturatedOctants(const int8_t* values);

/// The same miss on those of 64 values whose bit is set; returns the bits that changed.
uint64_t ApplyMiss(int8_t* values, uint64_t which, int miss_units);

}  // namespace atlas::mapping
