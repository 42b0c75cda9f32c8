// The Atlas as a map: `mapper.name: atlas`.
#include "mapping/atlas/atlas.h"

#include <fmt/format.h>

#include "core/files.h"
#include "mapping/backends/builders.h"
#include "mapping/io/map_file.h"

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
    for (const auto& submap : atlas_.submaps()) members.push_back({submap->id, submap->keyframes});
    return members;
  }

  std::string Save(const std::filesystem::path& directory) const override {
    const std::filesystem::path folder = directory / "atlas";
    std::string list = "submap,root_keyframe,keyframes,overlap,file,x_m,y_m,z_m,qx,qy,qz,qw\n";
    for (const auto& submap : atlas_.submaps()) {
      const std::string file = fmt::format("submap_{:03d}.atlas", submap->id);
      WriteMap(folder / file, submap->contents.Read().tree);
      const core::Vec3& p = submap->T_map_submap.translation();
      const Eigen::Quaterniond q(submap->T_map_submap.linear());
      list += fmt::format("{},{},{},{:.4f},{},{:.6f},{:.6f},{:.6f},{:.9f},{:.9f},{:.9f},{:.9f}\n", submap->id,
                          submap->root, submap->keyframes.size(), submap->overlap, file, p.x(), p.y(), p.z(),
                          q.x(), q.y(), q.z(), q.w());
    }
    core::WriteFileAtomically(folder / "submaps.csv", list);
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
