// The Atlas as a map: `mapper.name: atlas`.
#include "mapping/atlas/atlas.h"

#include "mapping/backends/builders.h"

namespace atlas::mapping {
namespace {

class AtlasMap final : public Map {
 public:
  AtlasMap(const MapperParams& params, const MapSetup& setup)
      : atlas_(params.atlas, {params.resolution_m, params.integrator, setup, params.behind_surface_m}) {}

  void Integrate(const core::AnchoredSpin& spin, const core::PoseSource& poses) override {
    atlas_.Integrate(spin, poses);
  }
  void Correct(const core::PoseSource& poses) override { atlas_.Correct(poses); }
  std::shared_ptr<const MapView> Snapshot() const override { return atlas_.Snapshot(); }
  size_t Bytes() const override { return atlas_.Bytes(); }
  size_t SubmapCount() const override { return atlas_.submaps().size(); }
  std::vector<SubmapMembers> Submaps() const override {
    std::vector<SubmapMembers> members;
    for (const auto& submap : atlas_.submaps()) {
      members.push_back({submap->id, {}});
      for (const HeldKeyframe& held : submap->keyframes)
        members.back().keyframes.push_back(held.sensor.keyframe);
    }
    return members;
  }

  std::string Save(const std::filesystem::path& directory) const override {
    WriteAtlas(directory / "atlas", atlas_.Saved());
    return "atlas";
  }

 private:
  Atlas atlas_;
};

}  // namespace

std::unique_ptr<Map> BuildAtlasMap(const MapperParams& params, const MapSetup& setup) {
  return std::make_unique<AtlasMap>(params, setup);
}

}  // namespace atlas::mapping
