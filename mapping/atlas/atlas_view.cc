#include "mapping/atlas/atlas_view.h"

#include <algorithm>
#include <cmath>

#include "core/rng.h"
#include "mapping/octree/voxel_ray.h"

namespace atlas::mapping {
namespace {

using core::Box3;
using core::Pose;
using core::Vec3;

/// Pieces of a ray shorter than this are what rounding leaves at the faces of voxels.
constexpr double kSliverM = 1e-6;
constexpr uint64_t kKeySalt = 0x51b3a95;

bool Measured(const RaySample& sample) {
  return sample.occupancy != 0.5f || sample.state != CellState::kUnknown;
}

OctreeView EmptyView(double resolution_m) {
  return {std::make_shared<const OctreeContents>(OctreeContents{OccupancyOctree(resolution_m), {}}), {}};
}

/// The part of a ray that a map holds, metres along it.
struct LineSpan {
  Vec3 origin = Vec3::Zero(), direction = Vec3::Zero();
  double from_m = 0.0, to_m = 0.0;
};

}  // namespace

/// A ray on its way through one map, sample by sample. An occupied voxel ends a trace, not the way: should a
/// newer map have overruled it, the ray is traced on behind it.
class AtlasView::RayThrough {
 public:
  /// Begins a ray, in the map's own frame. `salt` keeps the keys of maps apart; 0: as they are.
  void Begin(const OctreeView& view, uint64_t salt, const LineSpan& line, const TraceLimits& limits) {
    view_ = &view;
    salt_ = salt;
    line_ = line;
    limits_ = limits;
    samples_.clear();
    next_ = 0;
    begin_m_ = -1.0;
    sample_ = nullptr;
    ended_ = false;
  }

  /// Makes the sample that holds `t` the current one. @pre `t` never falls.
  void MoveTo(double t) {
    sample_ = nullptr;
    end_m_ = t < line_.from_m ? line_.from_m : std::numeric_limits<double>::infinity();
    if (t < line_.from_m || t >= line_.to_m - kSliverM) return;
    while (true) {
      for (; next_ < samples_.size() && begin_m_ + Length(next_) <= t + kSliverM; ++next_)
        begin_m_ += Length(next_);
      if (next_ < samples_.size()) {
        sample_ = &samples_[next_];
        end_m_ = std::min(begin_m_ + Length(next_), line_.to_m);
        return;
      }
      if (ended_) return;
      Load(begin_m_ < t ? t : begin_m_ + kSliverM);
    }
  }

  /// Null outside of the map.
  const RaySample* sample() const { return sample_; }
  double begin_m() const { return begin_m_; }
  /// The current sample under a key that is the map's own; `behind` where it is unmeasured.
  RaySample Keyed(float behind) const {
    RaySample keyed = *sample_;
    if (salt_ != 0) keyed.key = core::HashCounter(salt_, keyed.key);
    if (!Measured(keyed)) keyed.behind_surface = behind;
    return keyed;
  }
  /// Of the current sample; before the map: where it begins.
  double end_m() const { return end_m_; }

 private:
  double Length(size_t i) const { return static_cast<double>(samples_[i].length_m); }

  void Load(double t) {
    begin_m_ = t;
    next_ = 0;
    samples_.clear();
    ended_ = t >= line_.to_m - kSliverM;
    if (ended_) return;
    limits_.max_range_m = line_.to_m - t;
    ended_ = view_->Trace(line_.origin + t * line_.direction, line_.direction, limits_, &samples_) ==
             RayEnd::kVoid;
  }

  const OctreeView* view_ = nullptr;
  uint64_t salt_ = 0;
  LineSpan line_;
  TraceLimits limits_;
  std::vector<RaySample> samples_;
  size_t next_ = 0;
  double begin_m_ = -1.0;  ///< of samples_[next_]; what was loaded reaches to it where there is none
  double end_m_ = 0.0;
  const RaySample* sample_ = nullptr;
  bool ended_ = false;  ///< nothing comes after samples_
};

/// Gathers pieces of samples; those of one sample that follow each other are one.
class AtlasView::PieceSink {
 public:
  PieceSink(const TraceLimits& limits, std::vector<RaySample>* samples)
      : met_(limits, samples), out_(*samples) {}

  /// The part `span_m` of `sample`, which begins at `begin_m`. Returns false where the ray ends.
  bool Add(const RaySample& sample, double begin_m, std::pair<double, double> span_m) {
    const auto length = static_cast<float>(span_m.second - span_m.first);
    const float share = sample.length_m > 0.0f ? length / sample.length_m : 1.0f;
    const auto voxels = static_cast<uint32_t>(std::lround(share * static_cast<float>(sample.voxels)));
    if (!out_.empty() && sample.key == last_key_ && begin_m == last_begin_m_) {
      out_.back().length_m += length;
      if (sample.voxels > 1) out_.back().voxels += voxels;
      return true;
    }
    last_key_ = sample.key;
    last_begin_m_ = begin_m;
    RaySample piece = sample;
    piece.length_m = length;
    piece.voxels = std::max(1u, voxels);
    return met_.Add(piece);
  }

 private:
  RaySamples met_;
  std::vector<RaySample>& out_;
  uint64_t last_key_ = 0;
  double last_begin_m_ = -1.0;
};

AtlasView::AtlasView(double resolution_m, std::vector<PosedSubmap> submaps, const Box3& keep_map)
    : resolution_m_(resolution_m),
      submaps_(std::move(submaps)),
      pins_(std::make_unique<Pin[]>(submaps_.size())),
      keep_map_(keep_map),
      nothing_(EmptyView(resolution_m)) {
  for (const PosedSubmap& submap : submaps_) {
    T_submap_map_.push_back(submap.T_map_submap.inverse());
    index_.Add(*submap.outline, submap.T_map_submap);
  }
  index_.Build();
}

const OctreeView& AtlasView::ViewOf(size_t submap) const {
  Pin& pin = pins_[submap];
  std::call_once(pin.once,
                 [&] { pin.view.emplace(submaps_[submap].contents->Get(), submaps_[submap].states); });
  return *pin.view;
}

template <typename Views>
size_t AtlasView::FirstThatMeasured(const Vec3& p_map, const Views& view_of, CellState* state) const {
  for (const uint16_t i : index_.At(p_map)) {
    const Vec3 p_submap = T_submap_map_[i] * p_map;
    if (!submaps_[i].outline->bounds.Contains(p_submap)) continue;
    if (const auto measured = view_of(i).MeasuredStateAt(p_submap)) {
      *state = *measured;
      return i;
    }
  }
  return submaps_.size();
}

size_t AtlasView::RightAbout(const Vec3& p_map) const {
  CellState state;
  return FirstThatMeasured(
      p_map, [this](size_t i) -> const OctreeView& { return ViewOf(i); }, &state);
}

CellState AtlasView::StateAt(const Vec3& p_map) const {
  CellState state = CellState::kUnknown;
  if (keep_map_.Contains(p_map))
    FirstThatMeasured(
        p_map, [this](size_t i) -> const OctreeView& { return ViewOf(i); }, &state);
  return state;
}

uint32_t AtlasView::SubmapAt(const Vec3& p_map) const {
  const size_t first = RightAbout(p_map);
  return first < submaps_.size() ? submaps_[first].id : 0;
}

/// A ray's way through each of the submaps that it has met so far. A thread keeps one for all its rays, so
/// that the samples' memory is taken once.
class AtlasView::Throughs {
 public:
  void Begin(const AtlasView& atlas, const LineSpan& line, const TraceLimits& limits) {
    atlas_ = &atlas;
    line_ = line;
    limits_ = limits;
    limits_.box_map = TraceLimits{}.box_map;
    nothing_.Begin(atlas.nothing_, 0, line, limits_);
    limits_.each_unmeasured = false;
    const auto kept = atlas.keep_map_.Clip(line.origin, line.direction);
    kept_ = kept.value_or(std::pair(1.0, 0.0));
    if (submaps_.size() < atlas.submaps_.size()) {
      submaps_.resize(atlas.submaps_.size());
      begun_.resize(atlas.submaps_.size());
    }
    begun_.assign(begun_.size(), 0);
  }
  RayThrough& Nothing() { return nothing_; }
  RayThrough& Of(size_t submap) {
    if (!std::exchange(begun_[submap], 1)) Enter(submap);
    return submaps_[submap];
  }

 private:
  void Enter(size_t i) {
    const Pose& T = atlas_->T_submap_map_[i];
    LineSpan own{T * line_.origin, T.linear() * line_.direction, 1.0, 0.0};
    if (const auto inside = atlas_->submaps_[i].outline->bounds.Clip(own.origin, own.direction)) {
      own.from_m = std::max({line_.from_m, kept_.first, inside->first});
      own.to_m = std::min({line_.to_m, kept_.second, inside->second});
    }
    if (own.from_m >= own.to_m) own.from_m = own.to_m = std::numeric_limits<double>::infinity();
    submaps_[i].Begin(atlas_->ViewOf(i), core::HashCounter(kKeySalt, atlas_->submaps_[i].id), own, limits_);
  }

  const AtlasView* atlas_ = nullptr;
  LineSpan line_;
  TraceLimits limits_;
  std::pair<double, double> kept_;
  RayThrough nothing_;
  std::vector<RayThrough> submaps_;
  std::vector<uint8_t> begun_;
};

/// One cell of the index, from t to t_end: what the newest submap in it has measured, piece by piece.
bool AtlasView::CrossCell(std::span<const uint16_t> submaps, std::pair<double, double> span_m,
                          Throughs* throughs, PieceSink* met) {
  for (double t = span_m.first, end; t < span_m.second - kSliverM; t = end) {
    end = span_m.second;
    const RayThrough* right = nullptr;
    float behind = 0.0f;
    for (auto submap = submaps.begin(); submap != submaps.end() && right == nullptr; ++submap) {
      RayThrough& through = throughs->Of(*submap);
      through.MoveTo(t);
      end = std::min(end, through.end_m());
      if (through.sample() == nullptr) continue;
      if (Measured(*through.sample())) right = &through;
      behind = std::max(behind, through.sample()->behind_surface);
    }
    if (right == nullptr) {
      throughs->Nothing().MoveTo(t);
      end = std::min(end, throughs->Nothing().end_m());
      right = &throughs->Nothing();
    }
    if (right->sample() == nullptr || end - t < kSliverM) continue;
    if (!met->Add(right->Keyed(behind), right->begin_m(), {t, end})) return false;
  }
  return true;
}

RayEnd AtlasView::Trace(const Vec3& origin_map, const Vec3& direction_map, const TraceLimits& limits,
                        std::vector<RaySample>* samples) const {
  PieceSink met(limits, samples);
  const auto span = limits.box_map.Clip(origin_map, direction_map);
  if (!span || span->first >= limits.max_range_m) return RayEnd::kVoid;
  const double t_end = std::min(span->second, limits.max_range_m);
  thread_local Throughs throughs;
  throughs.Begin(*this, {origin_map, direction_map, span->first, t_end}, limits);

  // Before and behind the index nothing is measured.
  const auto indexed =
      index_.bounds_map().Empty() ? std::nullopt : index_.bounds_map().Clip(origin_map, direction_map);
  const double from = indexed ? std::clamp(indexed->first, span->first, t_end) : t_end,
               to = indexed ? std::clamp(indexed->second, from, t_end) : t_end;
  CrossCell({}, {span->first, from}, &throughs, &met);
  if (from < to) {
    VoxelRay cells(origin_map, direction_map, index_.cell_m(), from, to,
                   VoxelsOf(TraceLimits{}.box_map, index_.cell_m()));
    double t = from;
    bool occupied = false, on = true;
    while (on) {
      on = cells.CrossVoxels(&occupied, [&](int, double length_m) {
        const double begin = std::exchange(t, t + length_m);
        const Vec3 middle = origin_map + (begin + 0.5 * length_m) * direction_map;
        return CrossCell(index_.At(middle), {begin, t}, &throughs, &met);
      });
    }
    if (occupied) return RayEnd::kOccupied;
  }
  CrossCell({}, {to, t_end}, &throughs, &met);
  return RayEnd::kVoid;
}

void AtlasView::ForEachOccupied(const Box3& box_map, const VisitCenter& visit) const {
  // Lent for one submap's listing each: to list a map does not keep it in memory.
  std::vector<std::optional<OctreeView>> lent(submaps_.size());
  const auto view_of = [&](size_t i) -> const OctreeView& {
    if (!lent[i]) lent[i].emplace(submaps_[i].contents->Get(), submaps_[i].states);
    return *lent[i];
  };
  for (size_t i = 0; i < submaps_.size(); ++i) {
    const Pose& T_map_submap = submaps_[i].T_map_submap;
    const Box3 bounds_map = BoxAround(submaps_[i].outline->bounds, T_map_submap);
    const Box3 both{box_map.min.cwiseMax(bounds_map.min), box_map.max.cwiseMin(bounds_map.max)};
    if (both.Empty()) continue;
    const Box3 box_submap = BoxAround(both, T_submap_map_[i]);
    view_of(i).ForEachOccupied(box_submap, [&](const core::Vec3f& center_submap) {
      const Vec3 center_map = T_map_submap * center_submap.cast<double>();
      if (!box_map.Contains(center_map) || !keep_map_.Contains(center_map)) return;
      CellState state;
      if (FirstThatMeasured(center_map, view_of, &state) == i) visit(center_map.cast<float>());
    });
    for (auto& view : lent) view.reset();
  }
}

}  // namespace atlas::mapping
