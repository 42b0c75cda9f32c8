// YAML that a user wrote (configs, sweeps, scenes, routes): one loader, which refuses what could be
// understood in two ways and what could exhaust the machine.
#pragma once

#include <yaml-cpp/yaml.h>

#include <cstddef>
#include <filesystem>
#include <string>

namespace atlas::core {

/// Limits of one document, aliases counted as often as they stand. A part of a scene file with every field
/// spelt out is 26 nodes, so that 7,500 such parts fit.
inline constexpr size_t kMostYamlDepth = 32;
inline constexpr size_t kMostYamlNodes = 200000;

/// The one document of `text`; a null node where it is empty. @throws InputError "WHERE:LINE: what" for
/// malformed YAML, a second document, a key that is no plain text or stands twice in one mapping, an alias
/// inside of what it names, or more than the limits.
YAML::Node ParseYaml(const std::string& text, const std::string& where);

/// The same of a file. @throws InputError also when it cannot be read.
YAML::Node LoadYaml(const std::filesystem::path& file);

}  // namespace atlas::core
