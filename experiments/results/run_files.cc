#include "experiments/results/run_files.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <sstream>

#include "core/errors.h"
#include "core/files.h"
#include "experiments/results/run_recorder.h"

namespace atlas::experiments {
namespace {

using core::InputError;

std::vector<std::string> SplitLine(const std::string& line) {
  std::vector<std::string> cells;
  std::stringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  if (line.ends_with(',')) cells.emplace_back();
  return cells;
}

size_t ColumnOf(const std::vector<std::string>& header, const std::string& name, const std::string& origin) {
  for (size_t i = 0; i < header.size(); ++i) {
    if (header[i] == name) return i;
  }
  throw InputError(fmt::format("{}: column '{}' is missing", origin, name));
}

/// @throws InputError for a row that was cut short.
void CheckWidth(const std::vector<std::string>& cells, const std::vector<std::string>& header,
                const std::string& origin, int line) {
  if (cells.size() == header.size()) return;
  throw InputError(
      fmt::format("{}:{}: {} cells, the header has {}", origin, line, cells.size(), header.size()));
}

double NumberIn(const std::vector<std::string>& cells, size_t column, const std::string& origin, int line) {
  double value = 0.0;
  const std::string cell = column < cells.size() ? cells[column] : "";
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value)) {
    throw InputError(
        fmt::format("{}:{}: expected a number in column {}, found '{}'", origin, line, column + 1, cell));
  }
  return value;
}

}  // namespace

std::string_view NameOf(const planner::Decision& decision) {
  if (std::holds_alternative<planner::GoScan>(decision)) return "view";
  if (const auto* stuck = std::get_if<planner::Stuck>(&decision)) {
    return stuck->reason == planner::Stuck::Reason::kOutOfReach ? "out_of_reach" : "no_candidates";
  }
  using Reason = planner::Done::Reason;
  switch (std::get<planner::Done>(decision).reason) {
    case Reason::kGainExhausted:
      return "gain_exhausted";
    case Reason::kExplored:
      return "explored";
    case Reason::kSurfaceFlat:
      return "surface_flat";
    case Reason::kRouteDone:
      return "route_done";
    case Reason::kBlockedNarrow:
      return "blocked_narrow";
  }
  return "";
}

std::string_view NameOf(planner::LossReason reason) {
  switch (reason) {
    case planner::LossReason::kChosen:
      return "chosen";
    case planner::LossReason::kLowerUtility:
      return "lower_utility";
    case planner::LossReason::kBlacklisted:
      return "blacklisted";
    case planner::LossReason::kUnreachable:
      return "unreachable";
    case planner::LossReason::kNoGain:
      return "no_gain";
  }
  return "";
}

std::string CandidatesCsvHeader(const std::vector<std::string>& extra_gains) {
  std::string header =
      "scan,candidate,node,x_m,y_m,yaw_rad,ground_m,path_length_m,gain,gain_void,gain_ground,gain_object,"
      "surface_m2,worth,"
      "visited_cost,too_close_cost,position_cost,traversal_cost,utility,reason";
  for (const std::string& name : extra_gains) header += ",gain_" + name;
  return header + "\n";
}

void AppendCandidateRows(int scan, const planner::DecisionLog& log, size_t extra_count, std::string* csv) {
  for (size_t i = 0; i < log.candidates.size(); ++i) {
    const planner::Candidate& c = log.candidates[i];
    const auto number = [&](const std::optional<double>& value) {
      *csv += value ? fmt::format("{:.6g},", *value) : ",";
    };
    const auto of_gain = [&](double value) { number(c.gain ? std::optional(value) : std::nullopt); };
    const auto cost = [&](double value) { *csv += c.utility ? fmt::format("{:.4f},", value) : ","; };
    *csv += fmt::format("{},{},{},{:.3f},{:.3f},{:.4f},{:.3f},{:.3f},", scan, i, c.node, c.p_map.x(),
                        c.p_map.y(), c.yaw_rad, c.ground_m, c.path_length_m);
    number(c.gain);
    for (const double part : {c.gain_void, c.gain_ground, c.gain_object}) of_gain(part);
    number(c.surface_m2);
    number(c.worth);
    for (const double one : {c.visited_cost, c.too_close_cost, c.position_cost, c.traversal_cost}) cost(one);
    number(c.utility);
    *csv += NameOf(c.reason);
    for (size_t k = 0; k < extra_count; ++k) {
      *csv += k < c.extra_gains.size() ? fmt::format(",{:.6g}", c.extra_gains[k]) : ",";
    }
    *csv += '\n';
  }
}

CoverageCurve LoadCoverageCurve(const std::filesystem::path& run_folder) {
  const std::string origin = (run_folder / "steps.csv").string();
  std::stringstream text(core::ReadFile(origin));
  std::string line;
  std::getline(text, line);
  const std::vector<std::string> header = SplitLine(line);
  const size_t scan = ColumnOf(header, "scan", origin), time = ColumnOf(header, "sim_time_s", origin),
               distance = ColumnOf(header, "distance_m", origin),
               raw = ColumnOf(header, "coverage_raw", origin), aligned = ColumnOf(header, "coverage", origin),
               share = ColumnOf(header, "coverage_of_attainable", origin);
  CoverageCurve curve;
  for (int number = 2; std::getline(text, line); ++number) {
    if (line.empty()) continue;
    const std::vector<std::string> cells = SplitLine(line);
    CheckWidth(cells, header, origin, number);
    curve.scan.push_back(NumberIn(cells, scan, origin, number));
    curve.sim_time_s.push_back(NumberIn(cells, time, origin, number));
    curve.distance_m.push_back(NumberIn(cells, distance, origin, number));
    curve.coverage_raw.push_back(NumberIn(cells, raw, origin, number));
    curve.coverage.push_back(NumberIn(cells, aligned, origin, number));
    if (share < cells.size() && !cells[share].empty()) {
      curve.coverage_of_attainable.push_back(NumberIn(cells, share, origin, number));
    }
  }
  if (curve.coverage_of_attainable.size() != curve.scan.size()) curve.coverage_of_attainable.clear();
  return curve;
}

std::vector<core::Vec2> LoadScanPlaces(const std::filesystem::path& run_folder) {
  const std::string origin = (run_folder / "steps.csv").string();
  std::stringstream text(core::ReadFile(origin));
  std::string line;
  std::getline(text, line);
  const std::vector<std::string> header = SplitLine(line);
  const size_t x = ColumnOf(header, "x_m", origin), y = ColumnOf(header, "y_m", origin);
  std::vector<core::Vec2> places;
  for (int number = 2; std::getline(text, line); ++number) {
    if (line.empty()) continue;
    const std::vector<std::string> cells = SplitLine(line);
    CheckWidth(cells, header, origin, number);
    places.emplace_back(NumberIn(cells, x, origin, number), NumberIn(cells, y, origin, number));
  }
  return places;
}

}  // namespace atlas::experiments
