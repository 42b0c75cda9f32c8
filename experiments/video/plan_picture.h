// The ground of a run from above: what the robot could walk on and why not, its way, its scans, and the ways
// that it thought too narrow.
#pragma once

#include <filesystem>

#include "sim/render/colored_mesh.h"

namespace atlas::experiments {

/// x to the right, y up, with a legend beside it; 2 cm a pixel up to 20 m, coarser beyond. Reads
/// terrain.pgm, terrain.yaml, steps.csv, trajectory_truth.tum and blocked_ways.csv of the run folder.
/// @throws InputError where one of them is missing or malformed.
sim::RgbImage PlanPicture(const std::filesystem::path& run_folder);

}  // namespace atlas::experiments
