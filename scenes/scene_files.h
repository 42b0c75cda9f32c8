// The files that a user's scene is made of: their fingerprint, and a copy that stands alone.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace atlas::scenes {

/// What tells the content of one scene from another's: a built-in one's name (its geometry belongs to the
/// program), else "STEM-HEX" over the file's fields and its meshes' bytes, wherever those lie.
/// @throws InputError for an unknown name or files that cannot be read.
std::string SceneDigest(const std::string& name_or_path);

/// A scene file and its meshes; none of a built-in scene. @throws InputError for files that cannot be read.
std::vector<std::filesystem::path> FilesOfScene(const std::string& name_or_path);

/// Copies a scene file and its meshes to `folder`, the copy naming the copies; the digest stays the same.
/// Comments are lost. Returns the copy's name in the folder. @throws InputError.
std::filesystem::path CopyScene(const std::filesystem::path& scene, const std::filesystem::path& folder);

/// The same to FOLDER/scene, and a built-in scene is not copied. Returns the scene's name as seen from the
/// folder: "scene/arch.yaml", "helicopter". @throws InputError for a scene that cannot be loaded.
std::string KeepScene(const std::string& name_or_path, const std::filesystem::path& folder);

}  // namespace atlas::scenes
