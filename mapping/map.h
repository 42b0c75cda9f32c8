// The map seam: anchored revolutions in, snapshots out.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/keyframe.h"
#include "core/lidar_model.h"
#include "mapping/map_view.h"

namespace atlas::mapping {

struct SavedAtlas;

/// What a map is made for.
struct MapSetup {
  std::optional<core::LidarModel> lidar = {};  ///< that the spins come from; absent where that is not known
  /// Nothing is kept outside; absent: all is kept.
  std::optional<core::Box3> keep_map = {};
  bool behind_surface = false;  ///< keep how far behind a hit unmeasured voxels lie (proximity count)
  /// `atlas`: goes on from this, whose keyframes come before all others; null: begins empty.
  std::shared_ptr<const SavedAtlas> earlier = {};
};

/// A rigid part of a map, and the keyframes whose revolutions it holds.
struct SubmapMembers {
  uint32_t id = 0;
  std::vector<core::KeyframeId> keyframes;
};

class Map {
 public:
  virtual ~Map() = default;
  /// Integrates one revolution, where `poses` puts it.
  virtual void Integrate(const core::AnchoredSpin& spin, const core::PoseSource& poses) = 0;
  /// Moves what is held to where keyframes lie by now. A rigid map stays as it is.
  virtual void Correct(const core::PoseSource&) {}
  /// The map as it is, for as long as it is held. A snapshot costs nothing while it is let go before the next
  /// Integrate(), and a copy of the map where it is not.
  virtual std::shared_ptr<const MapView> Snapshot() const = 0;
  virtual size_t Bytes() const = 0;
  /// Rigid parts.
  virtual size_t SubmapCount() const { return 1; }
  /// The rigid parts of a map that has many; empty for a map that is one.
  virtual std::vector<SubmapMembers> Submaps() const { return {}; }
  /// Writes the map in the backend's own format; returns the file's name.
  virtual std::string Save(const std::filesystem::path& directory) const = 0;
};

}  // namespace atlas::mapping
