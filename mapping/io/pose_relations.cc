#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "core/errors.h"
#include "mapping/io/scan_source.h"

namespace atlas::mapping {
namespace {

namespace fs = std::filesystem;
using core::Pose;

struct Relation {
  std::string a, b;
  Pose T_a_b;
};

/// The frames A and B of a file called T_A_B.txt, where both are among `frames`.
std::optional<std::pair<std::string, std::string>> FramesOf(const fs::path& file,
                                                            const std::set<std::string>& frames) {
  const std::string stem = file.stem().string();
  if (file.extension() != ".txt" || !stem.starts_with("T_")) return std::nullopt;
  for (size_t at = stem.find('_', 2); at != std::string::npos; at = stem.find('_', at + 1)) {
    const std::string a = stem.substr(2, at - 2), b = stem.substr(at + 1);
    if (frames.count(a) != 0 && frames.count(b) != 0) return std::pair{a, b};
  }
  return std::nullopt;
}

std::vector<Relation> ReadRelations(const fs::path& folder, const std::set<std::string>& frames) {
  std::vector<Relation> relations;
  std::error_code error;
  for (auto it = fs::directory_iterator(folder, error); !error && it != fs::directory_iterator();
       it.increment(error)) {
    const auto pair = FramesOf(it->path(), frames);
    if (!pair) continue;
    relations.push_back({pair->first, pair->second, ReadCalibration(it->path()).T_posed_lidar});
  }
  std::sort(relations.begin(), relations.end(),
            [](const Relation& x, const Relation& y) { return std::tie(x.a, x.b) < std::tie(y.a, y.b); });
  return relations;
}

std::string RootOf(const std::vector<Relation>& relations) {
  std::set<std::string> children;
  for (const Relation& relation : relations) children.insert(relation.b);
  for (const Relation& relation : relations) {
    if (children.count(relation.a) == 0) return relation.a;
  }
  return relations[0].a;
}

}  // namespace

std::vector<Pose> PosesFromRelations(const fs::path& folder, const std::vector<std::string>& stems) {
  std::set<std::string> frames(stems.begin(), stems.end());
  frames.insert({"map", "world"});
  const std::vector<Relation> relations = ReadRelations(folder, frames);
  if (relations.empty()) return {};
  std::map<std::string, Pose> T_map = {{RootOf(relations), Pose::Identity()}};
  for (size_t known = 0; known != T_map.size();) {
    known = T_map.size();
    for (const Relation& relation : relations) {
      const bool has_a = T_map.count(relation.a) != 0, has_b = T_map.count(relation.b) != 0;
      if (has_a && !has_b) T_map[relation.b] = T_map[relation.a] * relation.T_a_b;
      if (has_b && !has_a) T_map[relation.a] = T_map[relation.b] * relation.T_a_b.inverse();
    }
  }
  std::vector<Pose> poses;
  for (const std::string& stem : stems) {
    const auto found = T_map.find(stem);
    if (found == T_map.end())
      throw core::InputError(fmt::format("{}: no T_A_B.txt leads to cloud '{}'", folder.string(), stem));
    poses.push_back(found->second);
  }
  return poses;
}

}  // namespace atlas::mapping
