// Parameters as the layers give them, before anything is known of their types (params.cc).
#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace atlas::core {

/// A value as the user wrote it, and where.
struct ParamEntry {
  enum class Kind { kScalar, kSequence, kMap } kind = Kind::kMap;
  std::string origin;
  std::filesystem::path folder = {};  ///< of the file; empty for the command line
  std::string scalar;
  bool is_null = false;  ///< a scalar without any text, not even ""
  std::vector<std::string> sequence;
  std::map<std::string, ParamEntry> children;
};

/// "'text'", "a list" or "a section".
std::string KindText(const ParamEntry& entry);

/// What `node` of `file` (in `folder`) holds. @throws InputError for lists in lists and control characters.
ParamEntry EntryFromYaml(const YAML::Node& node, const std::string& file,
                         const std::filesystem::path& folder);

/// Merges `over` into `base`; a bare scalar for a section is shorthand for its name.
void MergeEntry(ParamEntry* base, ParamEntry over);

}  // namespace atlas::core
