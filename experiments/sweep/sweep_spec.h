// A sweep: experiments x a grid of settings x seeds, read from YAML and expanded to runs.
//
//   doc: Table 3.1 of the thesis
//   experiments: [helicopter, car] # or FILE.yaml; files are relative to this one
//   grid:                          # every combination, in this order
//     planner.gain: [occlusion_aware, rear_side_entropy]
//     planner.name: [thesis, greedy]
//   variants:                      # each with the whole grid; settings that go together, by a name
//     thesis_se_atlas: [planner=thesis, mapper=se_atlas]
//   seeds: 3                       # 1, 2, 3; or a list
//   set: [mission.max_scans=30]    # for all runs
//   estimate_s: 120                # wall time of a run, until an earlier one tells
//   limit_s: 3600                  # wall time after which a run is ended and counts as failed
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "experiments/identity/run_identity.h"

namespace atlas::experiments {

struct SweepSpec {
  std::string name;  ///< the file's stem
  std::string file;  ///< as given
  std::string doc;
  std::vector<std::string> experiments;
  std::vector<std::pair<std::string, std::vector<std::string>>> grid;      ///< parameter path, values
  std::vector<std::pair<std::string, std::vector<std::string>>> variants;  ///< name, assignments
  std::vector<uint64_t> seeds;
  std::vector<std::string> set;
  std::map<std::string, std::string> places;  ///< of each assignment: "FILE:LINE: grid.planner.gain"
  double estimate_s = 120.0;
  double limit_s = 0.0;  ///< 0: an hour, or ten times the estimate where that is longer
};

/// Wall time of one run after which it is ended (s).
double LimitOf(const SweepSpec& spec);

/// A sweep of experiments/configs/sweeps by name, or a user's file. @throws InputError for an unknown name
/// (suggesting the near one), malformed YAML, an unknown key, a wrong type or an empty list: file, line,
/// field, value, limit.
SweepSpec LoadSweep(const std::string& name_or_path);
/// Names of the sweeps that come with the installation, sorted.
std::vector<std::string> SweepNames();

struct SweepRun {
  std::string experiment;
  std::vector<std::string> assignments;  ///< "a.b=value", as for --set
  uint64_t seed = 0;
  std::shared_ptr<const RunIdentity> identity = nullptr;  ///< once identified (sweep.h)
  std::filesystem::path folder;                           ///< OUT/<experiment>_<value>_<value>/<seed>
};
/// Seeds vary fastest, then variants, then the grid's last key. Folders are named by the grid's values and
/// the variant. @throws InputError when two runs would share a folder.
std::vector<SweepRun> ExpandSweep(const SweepSpec& spec, const std::filesystem::path& out);

}  // namespace atlas::experiments
