// Place recognition: has the LiDAR been here before, and how was it turned and shifted then?
//
// A place is its plan: the cells of a grid, seen from above, in which something upright stands (walls,
// trunks; neither floor nor ceiling). Two plans of one place differ by a turn and a shift. The magnitude of
// the plan's 2-D spectrum does not change when it is shifted, and turns as the plan does (Fourier and Mellin;
// by slices of the Radon transform as in RING, Lu et al. 2022): its circular correlation over the angle finds
// the turn, up to 180 degrees, without knowing the shift. Plans that agree so far are laid on one another to
// find the shift and which half turn.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry.h"

namespace atlas::mapping {

struct PlaceDescriptor {
  static constexpr int kSide = 192;       ///< cells of the plan, a side
  static constexpr double kCell_m = 0.4;  ///< so that the plan reaches 38 m
  static constexpr int kCoarse = 3;       ///< cells of the plan in one of the coarse plan, a side
  static constexpr int kCoarseSide = kSide / kCoarse;
  static constexpr int kAngles = 128;  ///< over half a turn
  static constexpr int kTurns = 40;    ///< harmonics kept over the angle
  static constexpr int kWaves = 24;    ///< wavelengths kept: the plan's width over 1, 2, ..., down to 3.2 m

  struct Cell {
    int16_t x, y;
  };
  std::vector<Cell> cells;  ///< occupied, row by row
  /// The plan's cells and those beside them, a bit each; the coarse plan, bits of a row in one word.
  std::array<uint64_t, static_cast<size_t>(kSide* kSide / 64)> beside = {};
  std::array<uint64_t, static_cast<size_t>(kCoarseSide)> coarse = {};
  /// Over the angle, of the spectrum's magnitudes: a row a wavelength, of kTurns real and then kTurns
  /// imaginary parts; of unit norm.
  std::vector<float> spectrum;
};

/// @param p_level points in the keyframe's frame turned level (z up): the plan knows no tilt. Any range;
/// those beyond the plan are left out.
PlaceDescriptor DescribePlace(std::span<const core::Vec3f> p_level);
/// Of a plan's cells, as a descriptor lists them.
PlaceDescriptor DescribePlan(std::vector<PlaceDescriptor::Cell> cells);

/// What a query may be. A plan that agrees with itself turned by half has a candidate for either.
struct PlaceCandidate {
  uint32_t id = 0;
  double yaw_rad = 0.0;   ///< of T_candidate_query
  double distance = 1.0;  ///< 1 - Dice's coefficient of the two plans: 0 where they are one, 1 disjoint
  core::Pose T_candidate_query =
      core::Pose::Identity();  ///< level; to a plan's cell and 1.4 degrees; z unknown: 0
};

struct PlaceQueryParams {
  size_t skip_youngest = 0;    ///< of those added: where the LiDAR just was
  size_t verified = 12;        ///< plans laid on one another: those whose spectra correlate best
  double max_distance = 0.65;  ///< of a candidate
  double max_shift_m = 9.0;
};

class PlaceDatabase {
 public:
  /// @pre ids are distinct.
  void Add(uint32_t id, PlaceDescriptor place);
  size_t size() const { return ids_.size(); }
  /// In the order in which they were added.
  const PlaceDescriptor& place(size_t index) const { return places_[index]; }
  /// The nearest first; up to two for each id.
  std::vector<PlaceCandidate> Query(const PlaceDescriptor& place, const PlaceQueryParams& params) const;

 private:
  std::vector<uint32_t> ids_;
  std::vector<PlaceDescriptor> places_;
};

}  // namespace atlas::mapping
