// Information gains: what a view is expected to teach (thesis 3.4.1).
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mapping/map_view.h"

namespace atlas::planner {

/// Laws that a gain declares; tests/laws holds every catalogue entry to its own.
struct GainLaws {
  bool zero_on_certain_rays = true;        ///< occupancy 0 or 1 everywhere
  bool independent_of_voxel_size = false;  ///< length-normalised gains only
  bool at_most_occlusion_aware = false;
};

/// What a gain reads of its samples beyond states, lengths and counts of voxels: what nobody reads is joined
/// into runs, which rays cross in one step.
struct GainReads {
  bool each_free = false;        ///< the occupancy of each free voxel
  bool each_unmeasured = false;  ///< each never measured voxel by itself
  bool behind_surface = false;
};

/// Sees one view, ray by ray; per-ray sums, per-view ratios and unions over rays all fit. One instance a
/// thread.
class Gain {
 public:
  virtual ~Gain() = default;
  virtual void BeginView() = 0;
  /// The voxels of one ray up to its end. `weight` is how many sensor rays this one stands for.
  virtual void AddRay(std::span<const mapping::RaySample> samples, mapping::RayEnd end, double weight) = 0;
  /// @return the view's gain: finite, >= 0.
  virtual double FinishView() = 0;
};

/// A gain that is a weighted sum over rays (thesis Eq. 3.2): RayValue is computed once a ray, whatever the
/// number of views (headings of one node) that share it.
class RaySumGain : public Gain {
 public:
  /// What the ray contributes to a view at weight 1: finite, >= 0.
  virtual double RayValue(std::span<const mapping::RaySample> samples, mapping::RayEnd end) const = 0;

  void BeginView() final { sum_ = 0.0; }
  void AddRay(std::span<const mapping::RaySample> samples, mapping::RayEnd end, double weight) final {
    sum_ += weight * RayValue(samples, end);
  }
  double FinishView() final { return sum_; }

 private:
  double sum_ = 0.0;
};

/// A gain over the union of what a view's rays meet, which serves several views that share rays (headings of
/// one node) in one pass.
class SharedUnionGain : public Gain {
 public:
  virtual void BeginViews(size_t count) = 0;
  /// `weights[v]` is how many sensor rays of view v this one stands for; 0 where v does not see it.
  virtual void AddRayToViews(std::span<const mapping::RaySample> samples, mapping::RayEnd end,
                             std::span<const double> weights) = 0;
  /// @return the gain of each view: finite, >= 0.
  virtual std::vector<double> FinishViews() = 0;

  void BeginView() final { BeginViews(1); }
  void AddRay(std::span<const mapping::RaySample> samples, mapping::RayEnd end, double weight) final {
    AddRayToViews(samples, end, {&weight, 1});
  }
  double FinishView() final { return FinishViews()[0]; }
};

struct GainEntry {
  std::string name;
  std::string doc;  ///< one line with its source
  GainLaws laws;
  GainReads reads;
  std::unique_ptr<Gain> (*build)(double resolution_m);
};
const std::vector<GainEntry>& GainCatalog();
std::vector<std::string> GainNames();
/// @throws InputError for an unknown name, suggesting the near one.
const GainEntry& FindGain(const std::string& name);

/// H(p) = -p ln p - (1 - p) ln(1 - p), nats; 0 at 0 and 1 (thesis Eq. 3.3).
double Entropy(double p);

}  // namespace atlas::planner
