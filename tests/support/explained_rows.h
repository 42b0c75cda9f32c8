// Rows of `atlas explain`, each with another value that the parameter may have; and what a test can compare
// of all that a component tells.
#pragma once

#include <gtest/gtest.h>

#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <vector>

#include "core/files.h"
#include "experiments/identity/experiment_config.h"

namespace atlas::tests {

/// What a file holds, or all files of a folder, by their names.
inline std::string ContentOf(const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) return core::ReadFile(path);
  std::map<std::string, std::string> files;
  for (const auto& file : std::filesystem::directory_iterator(path))
    files[file.path().filename().string()] = core::ReadFile(file.path());
  std::string content;
  for (const auto& [name, text] : files) content += name + text;
  return content;
}

/// Numbers and texts one after another, kept as a hash: two that differ were not told the same.
class Digest {
 public:
  void AddBytes(const void* data, size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (size_t i = 0; i < size; ++i) hash_ = (hash_ ^ bytes[i]) * 1099511628211ull;
  }
  void Add(const std::string& text) { AddBytes(text.data(), text.size()); }
  template <typename T>
  void Add(const T& value) {
    if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
      AddBytes(&value, sizeof(value));
    } else {
      for (const auto& element : value) Add(element);
    }
  }
  void Add(const core::Pose& T) { AddBytes(T.matrix().data(), 16 * sizeof(double)); }
  void Add(const core::Vec2& p) { AddBytes(p.data(), 2 * sizeof(double)); }
  void Add(const core::Vec3& p) { AddBytes(p.data(), 3 * sizeof(double)); }
  void Add(const core::Vec3f& p) { AddBytes(p.data(), 3 * sizeof(float)); }
  std::string text() const { return std::to_string(hash_); }

 private:
  uint64_t hash_ = 14695981039346656037ull;
};

/// Settings under which a parameter acts, over those of its section, and a value to set it to ("": the next
/// one in its range).
struct Setting {
  std::vector<std::string> context;
  std::string value = "";
  std::string seen_by = "";  ///< a test that sees it act, where that takes a scene of its own
};
using Settings = std::map<std::string, Setting>;  ///< by path; a row that is not here needs none

/// Another value that the parameter may have: the next choice, the other flag, a number further on.
inline std::string NextValue(const core::ParamRow& row) {
  if (row.value == "true" || row.value == "false") return row.value == "true" ? "false" : "true";
  if (row.range.find(" | ") != std::string::npos) {
    const std::string twice = row.range + " | " + row.range;
    const size_t at = (" | " + twice + " | ").find(" | " + row.value + " | ");
    const size_t next = row.value.starts_with('[') ? 0 : twice.find(" | ", at) + 3;
    return twice.substr(next, twice.find(" | ", next) - next);
  }
  double value = 0.0, low = -1e300, high = 1e300;
  std::from_chars(row.value.data(), row.value.data() + row.value.size(), value);
  std::sscanf(row.range.c_str(), "[%lf, %lf]", &low, &high);
  const bool whole = row.value.find_first_of(".e") == std::string::npos;
  for (const double next :
       {2.0 * value, value + 1.0, 1.3 * value, value - 1.0, 0.5 * value, 0.5 * (low + high)}) {
    if (next == value || next < low || next > high) continue;
    if (whole && next != std::floor(next)) continue;
    return whole ? std::to_string(std::lround(next)) : nlohmann::json(next).dump();
  }
  return row.value;
}

/// Changes parameters one at a time and looks what follows; what was looked at is not looked at again. A
/// Config has `rows`, as resolved.
template <typename Config>
class ProbeOfConfig {
 public:
  using Load = std::function<Config(const std::vector<std::string>& assignments)>;
  using Look = std::function<std::string(const Config& config)>;

  ProbeOfConfig(Load load, Look look) : load_(std::move(load)), look_(std::move(look)) {}

  /// Expects that nothing but parameters changes what Look tells: without it, no difference would mean a
  /// thing.
  void SeeNothingElseAct(const std::vector<std::string>& context) {
    EXPECT_EQ(look_(load_(context)), Under(context)) << "the same settings, another outcome";
  }
  /// Expects of every parameter of a section ("": those without one) that another value lets Look tell
  /// something else. @return how many there are.
  int SeeThemAct(const std::string& section, const std::vector<std::string>& context,
                 const Settings& settings) {
    int seen = 0;
    for (const core::ParamRow& row : load_(context).rows) {
      const size_t dot = row.path.rfind('.');
      if ((dot == std::string::npos ? "" : row.path.substr(0, dot)) != section) continue;
      const auto found = settings.find(row.path);
      if (found != settings.end() && !found->second.seen_by.empty()) continue;
      SeeItAct(row.path, context, found == settings.end() ? Setting{} : found->second);
      ++seen;
    }
    EXPECT_GT(seen, 0) << section;
    return seen;
  }
  void SeeItAct(const std::string& path, const std::vector<std::string>& context, const Setting& setting) {
    std::vector<std::string> before = context;
    before.insert(before.end(), setting.context.begin(), setting.context.end());
    core::ParamRow here;
    for (const core::ParamRow& row : load_(before).rows) {
      if (row.path == path) here = row;
    }
    const std::string value = setting.value.empty() ? NextValue(here) : setting.value;
    ASSERT_NE(value, here.value) << path << ": no other value found in " << here.range;
    std::vector<std::string> after = before;
    after.push_back(path + "=" + value);
    EXPECT_NE(Under(before), Under(after)) << path << ": " << here.value << " or " << value;
  }

 private:
  const std::string& Under(const std::vector<std::string>& assignments) {
    std::string key;
    for (const std::string& assignment : assignments) key += assignment + " ";
    const auto [found, added] = told_.try_emplace(key);
    if (added) found->second = look_(load_(assignments));
    return found->second;
  }

  Load load_;
  Look look_;
  std::map<std::string, std::string> told_;
};

using ParameterProbe = ProbeOfConfig<experiments::ExperimentConfig>;

}  // namespace atlas::tests
