// A reader under fuzz, and the lists to which every room adds its own.
#pragma once

#include <cstring>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace atlas::fuzz {

/// Reads `bytes`, which also lie in `file` where `on_disk`. Throws InputError, naming `file`, or succeeds.
struct FuzzedReader {
  std::string file_name;           ///< "scan.pcd": the ending may decide what reads it
  std::vector<std::string> seeds;  ///< good files, small
  std::function<void(std::string_view bytes, const std::filesystem::path& file)> read;
  bool on_disk = false;
  bool detects_every_change = false;  ///< checksummed: nothing but the seeds themselves is read
};

std::vector<FuzzedReader> LogReaders();    ///< clouds, poses, graphs, beams, whole logs
std::vector<FuzzedReader> MapReaders();    ///< map.atlas
std::vector<FuzzedReader> SceneReaders();  ///< scene files, meshes and robots
std::vector<FuzzedReader> RunReaders();    ///< experiments, sweeps, recordings, routes

/// Appends a number as it lies in memory.
template <typename T>
void Put(std::string* out, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  out->append(raw, sizeof(T));
}

}  // namespace atlas::fuzz
