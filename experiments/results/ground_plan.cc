#include "experiments/results/ground_plan.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/errors.h"
#include "core/files.h"
#include "core/yaml_text.h"
#include "mapping/terrain/grid_filters.h"

namespace atlas::experiments {
namespace {

using core::InputError;
using mapping::GroundKind;

static_assert(static_cast<int>(GroundKind::kCutOff) == static_cast<int>(GroundCode::kCutOff),
              "the first codes are the kinds");

constexpr int kMostCells = 1 << 28;
constexpr double kFarthest_m = 1e6, kFinest_m = 1e-3, kCoarsest_m = 100.0;

/// Squared distance in cells below which a cell is nearer than `distance_m` to one that is not free.
int Within2(double distance_m, double cell_m) {
  const double cells = distance_m / cell_m;
  return static_cast<int>(std::floor(cells * cells));
}

double NumberAt(const YAML::Node& yaml, const char* key, const std::string& origin) {
  double value = 0.0;
  if (!yaml[key] || !YAML::convert<double>::decode(yaml[key], value))
    throw InputError(fmt::format("{}: {}: expected a number", origin, key));
  return value;
}

}  // namespace

const char* NameOf(GroundCode code) {
  constexpr const char* kNames[kGroundCodes] = {"unknown", "free",      "obstacle", "step",
                                                "slope",   "roughness", "drop",     "overhang",
                                                "cut_off", "tight",     "narrow"};
  return kNames[static_cast<size_t>(code)];
}

void GroundPlan::Cover(int min_x, int min_y, int cols, int rows) {
  if (kind_.empty()) {
    min_x_ = min_x;
    min_y_ = min_y;
    cols_ = cols;
    rows_ = rows;
    kind_.assign(static_cast<size_t>(cols) * static_cast<size_t>(rows), GroundKind::kUnknown);
    return;
  }
  const int x0 = std::min(min_x_, min_x), x1 = std::max(min_x_ + cols_, min_x + cols);
  const int y0 = std::min(min_y_, min_y), y1 = std::max(min_y_ + rows_, min_y + rows);
  if (x0 == min_x_ && y0 == min_y_ && x1 - x0 == cols_ && y1 - y0 == rows_) return;
  std::vector<GroundKind> grown(static_cast<size_t>(x1 - x0) * static_cast<size_t>(y1 - y0),
                                GroundKind::kUnknown);
  for (int r = 0; r < rows_; ++r) {
    std::copy_n(kind_.begin() + static_cast<std::ptrdiff_t>(r) * cols_, cols_,
                grown.begin() + static_cast<std::ptrdiff_t>(r + min_y_ - y0) * (x1 - x0) + (min_x_ - x0));
  }
  kind_ = std::move(grown);
  min_x_ = x0;
  min_y_ = y0;
  cols_ = x1 - x0;
  rows_ = y1 - y0;
}

void GroundPlan::Learn(const mapping::TraversableGround& ground) {
  const core::Box3 window = ground.Window();
  const auto cells = [this](double m) { return static_cast<int>(std::lround(m / cell_m_)); };
  const int min_x = cells(window.min.x()), min_y = cells(window.min.y());
  const int cols = cells(window.Size().x()), rows = cells(window.Size().y());
  Cover(min_x, min_y, cols, rows);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < cols; ++c) {
      const GroundKind now =
          ground.KindAt(ground.OnRobotsLevel(cell_m_ * core::Vec2(min_x + c + 0.5, min_y + r + 0.5), 0.0));
      GroundKind& known = kind_[static_cast<size_t>(r + min_y - min_y_) * static_cast<size_t>(cols_) +
                                static_cast<size_t>(c + min_x - min_x_)];
      const bool tells_nothing =
          now == GroundKind::kUnknown || (now == GroundKind::kCutOff && known == GroundKind::kFree);
      if (!tells_nothing) known = now;
    }
  }
}

GroundImage GroundPlan::Image() const {
  GroundImage image{rows_, cols_, cell_m_, cell_m_ * core::Vec2(min_x_, min_y_), {}};
  mapping::terrain::Mask blocked(kind_.size());
  for (size_t i = 0; i < kind_.size(); ++i) blocked[i] = kind_[i] != GroundKind::kFree;
  const int narrow2 = Within2(half_width_m_, cell_m_), tight2 = Within2(turning_radius_m_, cell_m_);
  const std::vector<int16_t> d2 = mapping::terrain::SquaredDistance(
      blocked, rows_, cols_, static_cast<int>(std::ceil(turning_radius_m_ / cell_m_)) + 1);
  for (size_t i = 0; i < kind_.size(); ++i) {
    GroundCode code = static_cast<GroundCode>(kind_[i]);
    if (code == GroundCode::kFree && d2[i] <= tight2)
      code = d2[i] <= narrow2 ? GroundCode::kNarrow : GroundCode::kTight;
    image.code.push_back(code);
  }
  return image;
}

void GroundPlan::Write(const std::filesystem::path& folder) const {
  const GroundImage image = Image();
  std::string pgm = fmt::format("P5\n{} {}\n255\n", image.cols, image.rows);
  for (int r = image.rows - 1; r >= 0; --r) {
    for (int c = 0; c < image.cols; ++c) {
      pgm += static_cast<char>(
          image.code[static_cast<size_t>(r) * static_cast<size_t>(image.cols) + static_cast<size_t>(c)]);
    }
  }
  core::WriteFileAtomically(folder / kGroundImageFile, pgm);
  std::string yaml =
      fmt::format("image: {}\nresolution: {:.4f}\norigin: [{:.4f}, {:.4f}, 0.0]\nmode: raw\nlegend:\n",
                  kGroundImageFile, image.cell_m, image.origin.x(), image.origin.y());
  for (int code = 0; code < kGroundCodes; ++code) {
    yaml += fmt::format("  {}: {}\n", code, NameOf(static_cast<GroundCode>(code)));
  }
  core::WriteFileAtomically(folder / kGroundLegendFile, yaml);
}

GroundImage LoadGroundImage(const std::filesystem::path& folder) {
  const std::string legend = (folder / kGroundLegendFile).string(),
                    file = (folder / kGroundImageFile).string();
  GroundImage image;
  try {
    const YAML::Node yaml = core::LoadYaml(legend);
    image.cell_m = NumberAt(yaml, "resolution", legend);
    if (!yaml["origin"].IsSequence() || yaml["origin"].size() < 2)
      throw InputError(legend + ": origin: expected [x, y, 0]");
    image.origin = core::Vec2(yaml["origin"][0].as<double>(), yaml["origin"][1].as<double>());
    if (!image.origin.allFinite() || image.origin.norm() > kFarthest_m)
      throw InputError(fmt::format("{}: origin: must lie within {} m", legend, kFarthest_m));
    if (!(image.cell_m >= kFinest_m && image.cell_m <= kCoarsest_m))
      throw InputError(fmt::format("{}: resolution: is {}, must be {} to {} m", legend, image.cell_m,
                                   kFinest_m, kCoarsest_m));
  } catch (const YAML::Exception& error) {
    throw InputError(fmt::format("{}:{}: {}", legend, std::max(error.mark.line, 0) + 1, error.msg));
  }
  const std::string pgm = core::ReadFile(file);
  std::istringstream head(pgm.substr(0, 64));
  std::string magic;
  int most = 0;
  head >> magic >> image.cols >> image.rows >> most;
  const bool sane = magic == "P5" && most == 255 && image.cols > 0 && image.rows > 0 &&
                    image.rows <= kMostCells / image.cols;
  const size_t count = sane ? static_cast<size_t>(image.cols) * static_cast<size_t>(image.rows) : 0;
  if (!sane || pgm.size() < count + static_cast<size_t>(head.tellg()) + 1)
    throw InputError(file + ": expected a binary PGM (P5) of 8 bits, whole");
  const size_t first = static_cast<size_t>(head.tellg()) + 1;
  image.code.resize(count);
  for (int r = 0; r < image.rows; ++r) {
    for (int c = 0; c < image.cols; ++c) {
      const size_t from =
          static_cast<size_t>(image.rows - 1 - r) * static_cast<size_t>(image.cols) + static_cast<size_t>(c);
      const auto code = static_cast<uint8_t>(pgm[first + from]);
      if (code >= kGroundCodes)
        throw InputError(fmt::format("{}: a cell holds {}, must be 0 to {}", file, code, kGroundCodes - 1));
      image.code[static_cast<size_t>(r) * static_cast<size_t>(image.cols) + static_cast<size_t>(c)] =
          static_cast<GroundCode>(code);
    }
  }
  return image;
}

std::string TextOf(const planner::BlockedWay& way) {
  return fmt::format("at ({:.1f}, {:.1f}): {:.2f} m wide, {:.2f} m needed", way.p_map.x(), way.p_map.y(),
                     way.width_m, way.needed_m);
}

std::string BlockedWaysCsv(const std::vector<planner::BlockedWay>& ways) {
  std::string csv = "x_m,y_m,width_m,needed_m,worth_share\n";
  for (const planner::BlockedWay& way : ways) {
    csv += fmt::format("{:.3f},{:.3f},{:.3f},{:.3f},{}\n", way.p_map.x(), way.p_map.y(), way.width_m,
                       way.needed_m, way.worth_share ? fmt::format("{:.4f}", *way.worth_share) : "");
  }
  return csv;
}

std::vector<planner::BlockedWay> LoadBlockedWays(const std::filesystem::path& folder) {
  const std::string file = (folder / kBlockedWaysFile).string();
  std::istringstream text(core::ReadFile(file));
  std::string line;
  std::getline(text, line);
  std::vector<planner::BlockedWay> ways;
  for (int number = 2; std::getline(text, line); ++number) {
    if (line.empty()) continue;
    const bool judged = !line.ends_with(',');
    if (std::count(line.begin(), line.end(), ',') != 4 || line.find(",,") != std::string::npos)
      throw InputError(fmt::format("{}:{}: expected five numbers", file, number));
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream cells(line);
    planner::BlockedWay way;
    double share = 0.0;
    cells >> way.p_map.x() >> way.p_map.y() >> way.width_m >> way.needed_m;
    if (judged) cells >> share;
    if (!cells) throw InputError(fmt::format("{}:{}: expected five numbers", file, number));
    if (judged) way.worth_share = share;
    ways.push_back(way);
  }
  return ways;
}

}  // namespace atlas::experiments
