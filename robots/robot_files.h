// The files that a robot is made of: their fingerprint, and a copy that stands alone.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace atlas::robots {

/// "STEM-HEX" over a built-in robot's or a file's MJCF and the bytes of the meshes, textures and height
/// fields that it names, wherever those lie. @throws InputError for files that cannot be read.
std::string RobotDigest(const std::string& name_or_path);

/// The MJCF, what it includes, and the meshes, textures and height fields that it names.
/// @throws InputError for a robot that cannot be loaded.
std::vector<std::filesystem::path> FilesOfRobot(const std::string& name_or_path);

/// Copies a robot's MJCF and what it names to `folder`, the copy naming the copies; the digest stays the
/// same. Returns the copy's name in the folder. @throws InputError.
std::filesystem::path CopyRobot(const std::string& name_or_path, const std::filesystem::path& folder);

/// Where an MJCF's meshes and textures are looked for (`compiler` meshdir and texturedir, else its folder).
struct AssetFolders {
  std::filesystem::path meshes, textures;  ///< absolute
};
AssetFolders AssetFoldersOf(const std::filesystem::path& mjcf);

}  // namespace atlas::robots
