#include "planner/gain/view_evaluator.h"

#include <numeric>

#include "core/parallel_for.h"

namespace atlas::planner {
namespace {

using core::Vec3;
using mapping::RayEnd;
using mapping::RaySample;

/// Occupied ends no higher than this above the node's ground are ground.
constexpr double kGroundBand_m = 0.05;

/// Adds up one gain over the headings that share a node's rays.
class Accumulator {
 public:
  virtual ~Accumulator() = default;
  virtual void Begin(size_t headings) = 0;
  virtual void Add(const std::vector<RaySample>& samples, RayEnd end, EndClass end_class,
                   const std::vector<double>& weights) = 0;
  virtual double Total(size_t heading) = 0;
  virtual double OfEnd(size_t heading, EndClass end_class) = 0;
};

/// A sum over rays: the ray's value is computed once.
class SumAccumulator final : public Accumulator {
 public:
  SumAccumulator(const GainEntry& entry, double resolution_m)
      : owner_(entry.build(resolution_m)), gain_(dynamic_cast<const RaySumGain*>(owner_.get())) {}

  void Begin(size_t headings) override { sum_.assign(headings, {}); }
  void Add(const std::vector<RaySample>& samples, RayEnd end, EndClass end_class,
           const std::vector<double>& weights) override {
    const double value = gain_->RayValue(samples, end);
    if (value == 0.0) return;
    for (size_t h = 0; h < weights.size(); ++h) sum_[h][static_cast<size_t>(end_class)] += weights[h] * value;
  }
  double Total(size_t heading) override { return sum_[heading][0] + sum_[heading][1] + sum_[heading][2]; }
  double OfEnd(size_t heading, EndClass end_class) override {
    return sum_[heading][static_cast<size_t>(end_class)];
  }

 private:
  std::unique_ptr<Gain> owner_;
  const RaySumGain* gain_;
  std::vector<std::array<double, kEndClasses>> sum_;
};

/// Ratios: an instance a heading, and one more for each end class where the split is asked for.
class ViewAccumulator final : public Accumulator {
 public:
  ViewAccumulator(const GainEntry& entry, double resolution_m, bool split)
      : entry_(entry), resolution_m_(resolution_m), copies_(split ? 1 + kEndClasses : 1) {}

  void Begin(size_t headings) override {
    while (gain_.size() < headings * copies_) gain_.push_back(entry_.build(resolution_m_));
    for (size_t i = 0; i < headings * copies_; ++i) gain_[i]->BeginView();
  }
  void Add(const std::vector<RaySample>& samples, RayEnd end, EndClass end_class,
           const std::vector<double>& weights) override {
    for (size_t h = 0; h < weights.size(); ++h) {
      if (weights[h] <= 0.0) continue;
      gain_[h * copies_]->AddRay(samples, end, weights[h]);
      if (copies_ > 1)
        gain_[h * copies_ + 1 + static_cast<size_t>(end_class)]->AddRay(samples, end, weights[h]);
    }
  }
  double Total(size_t heading) override { return gain_[heading * copies_]->FinishView(); }
  double OfEnd(size_t heading, EndClass end_class) override {
    return copies_ > 1 ? gain_[heading * copies_ + 1 + static_cast<size_t>(end_class)]->FinishView() : 0.0;
  }

 private:
  const GainEntry& entry_;
  double resolution_m_;
  size_t copies_;
  std::vector<std::unique_ptr<Gain>> gain_;
};

/// Unions: one pass serves all headings; one more instance for each end class where the split is asked for.
class UnionAccumulator final : public Accumulator {
 public:
  UnionAccumulator(const GainEntry& entry, double resolution_m, bool split) {
    for (size_t i = 0; i < (split ? 1 + kEndClasses : 1); ++i) {
      owner_.push_back(entry.build(resolution_m));
      gain_.push_back(dynamic_cast<SharedUnionGain*>(owner_.back().get()));
    }
  }

  void Begin(size_t headings) override {
    value_.assign(gain_.size(), {});
    for (SharedUnionGain* gain : gain_) gain->BeginViews(headings);
  }
  void Add(const std::vector<RaySample>& samples, RayEnd end, EndClass end_class,
           const std::vector<double>& weights) override {
    gain_[0]->AddRayToViews(samples, end, weights);
    if (gain_.size() > 1) gain_[1 + static_cast<size_t>(end_class)]->AddRayToViews(samples, end, weights);
  }
  double Total(size_t heading) override { return Value(0, heading); }
  double OfEnd(size_t heading, EndClass end_class) override {
    return gain_.size() > 1 ? Value(1 + static_cast<size_t>(end_class), heading) : 0.0;
  }

 private:
  double Value(size_t instance, size_t heading) {
    if (value_[instance].empty()) value_[instance] = gain_[instance]->FinishViews();
    return value_[instance][heading];
  }

  std::vector<std::unique_ptr<Gain>> owner_;
  std::vector<SharedUnionGain*> gain_;
  std::vector<std::vector<double>> value_;
};

std::unique_ptr<Accumulator> MakeAccumulator(const GainEntry& entry, double resolution_m, bool split) {
  const std::unique_ptr<Gain> probe = entry.build(resolution_m);
  if (dynamic_cast<const RaySumGain*>(probe.get()) != nullptr) {
    return std::make_unique<SumAccumulator>(entry, resolution_m);
  }
  if (dynamic_cast<const SharedUnionGain*>(probe.get()) != nullptr) {
    return std::make_unique<UnionAccumulator>(entry, resolution_m, split);
  }
  return std::make_unique<ViewAccumulator>(entry, resolution_m, split);
}

/// Where the ray ends: samples are contiguous from its entry into the region.
EndClass ClassOf(RayEnd end, const std::vector<RaySample>& samples, const Vec3& origin, const Vec3& direction,
                 const core::Box3& region, double ground_m) {
  if (end == RayEnd::kVoid) return EndClass::kVoid;
  if (direction.z() >= 0.0) return EndClass::kObject;
  const auto inside = region.Clip(origin, direction);
  double reach_m = inside ? inside->first : 0.0;
  for (const RaySample& v : samples) reach_m += v.length_m;
  return origin.z() + reach_m * direction.z() <= ground_m + kGroundBand_m ? EndClass::kGround
                                                                          : EndClass::kObject;
}

}  // namespace

struct ViewEvaluator::Scratch {
  std::vector<RaySample> samples;
  std::vector<double> weights;
  std::vector<std::unique_ptr<Accumulator>> accumulators;
  size_t rays_traced = 0;
};

ViewEvaluator::ViewEvaluator(const SweepSensorModel& sensor, const ViewTarget& target,
                             EvaluatorOptions options)
    : view_(sensor),
      target_(target),
      options_(std::move(options)),
      limits_{.max_range_m = options_.max_range_m,
              .box_map = target.seen_box,
              .each_free = false,
              .each_unmeasured = false,
              .behind_surface = false} {
  for (const std::string& name : options_.gains) {
    entries_.push_back(&FindGain(name));
    const GainReads& reads = entries_.back()->reads;
    limits_.each_free |= reads.each_free;
    limits_.each_unmeasured |= reads.each_unmeasured;
    limits_.behind_surface |= reads.behind_surface;
  }
}

std::vector<std::vector<ViewGain>> ViewEvaluator::Evaluate(const mapping::MapView& map,
                                                           const std::vector<ViewNode>& nodes, int threads,
                                                           size_t* rays_traced) const {
  std::vector<std::vector<ViewGain>> result(nodes.size());
  std::vector<size_t> traced(nodes.size(), 0);
  core::ParallelFor(threads, nodes.size(), [&](size_t begin, size_t end, size_t) {
    Scratch scratch;
    for (size_t g = 0; g < entries_.size(); ++g) {
      scratch.accumulators.push_back(MakeAccumulator(*entries_[g], map.resolution_m(), g == 0));
    }
    for (size_t i = begin; i < end; ++i) {
      scratch.rays_traced = 0;
      result[i] = EvaluateNode(map, nodes[i], &scratch);
      traced[i] = scratch.rays_traced;
    }
  });
  if (rays_traced != nullptr) *rays_traced = std::accumulate(traced.begin(), traced.end(), size_t{0});
  return result;
}

std::vector<ViewGain> ViewEvaluator::EvaluateNode(const mapping::MapView& map, const ViewNode& node,
                                                  Scratch* scratch) const {
  const size_t headings = node.yaw_rad.size();
  const Vec3 origin = node.ground_map + Vec3(0.0, 0.0, view_.sensor_height_m());
  std::vector<ViewGain> views(headings);
  for (auto& accumulator : scratch->accumulators) accumulator->Begin(headings);
  scratch->weights.resize(headings);

  for (const RayDirection& ray :
       DirectionsInto(target_.object_box, origin, view_, options_.rays, options_.max_range_m)) {
    double seen = 0.0;
    for (size_t h = 0; h < headings; ++h) {
      const double weight =
          ray.solid_angle_sr * view_.RaysPerSteradian(ray.azimuth_rad - node.yaw_rad[h], ray.elevation_rad);
      scratch->weights[h] = weight;
      views[h].rays += weight > 0.0 ? 1 : 0;
      seen += weight;
    }
    if (seen <= 0.0) continue;
    const RayEnd end = map.Trace(origin, ray.direction_map, limits_, &scratch->samples);
    ++scratch->rays_traced;
    const EndClass end_class =
        ClassOf(end, scratch->samples, origin, ray.direction_map, target_.seen_box, node.ground_map.z());
    for (auto& accumulator : scratch->accumulators) {
      accumulator->Add(scratch->samples, end, end_class, scratch->weights);
    }
  }

  for (size_t h = 0; h < headings; ++h) {
    for (auto& accumulator : scratch->accumulators) views[h].gain.push_back(accumulator->Total(h));
    if (scratch->accumulators.empty()) continue;
    for (size_t e = 0; e < kEndClasses; ++e) {
      views[h].by_end[e] = scratch->accumulators.front()->OfEnd(h, static_cast<EndClass>(e));
    }
  }
  return views;
}

}  // namespace atlas::planner
