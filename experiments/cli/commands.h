// The commands behind `atlas`, one file each. Each returns the process's exit code and throws InputError for
// bad input.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace atlas::experiments {

struct RunArguments {
  std::string experiment;
  uint64_t seed = 1;
  int threads = 2;
  std::vector<std::string> assignments;
  std::filesystem::path out;  ///< empty: runs/<experiment>/<seed>
  bool video = false;
};
int RunCommand(const RunArguments& arguments);

int ListCommand(const std::string& what, bool verbose);
int ExplainCommand(const std::string& experiment, const std::vector<std::string>& assignments);
int BenchCommand(const std::string& what, const std::string& scene);

}  // namespace atlas::experiments
