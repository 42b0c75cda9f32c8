#include "mapping/slam/places.h"

#include <algorithm>
#include <bit>
#include <complex>

namespace atlas::mapping {
namespace {

using core::kPi;
using core::Pose;
using core::Vec3f;
using Place = PlaceDescriptor;
using PlanBits = decltype(Place::beside);
using CoarseBits = decltype(Place::coarse);

// An upright thing has points at three heights or more; floor and ceiling together have two.
constexpr float kBin_m = 0.3f, kLow_m = -3.0f;
constexpr int kBins = 32, kUprightBins = 3;
constexpr double kHalf_m = 0.5 * Place::kSide * Place::kCell_m;

bool InPlan(int x, int y) {
  return x >= 0 && y >= 0 && x < Place::kSide && y < Place::kSide;
}
size_t BitOf(int x, int y) {
  return static_cast<size_t>(y) * Place::kSide + static_cast<size_t>(x);
}
int CellAlong(double p_m) {
  return static_cast<int>(std::floor((p_m + kHalf_m) / Place::kCell_m));
}
double MiddleOf(int cell) {
  return (cell + 0.5) * Place::kCell_m - kHalf_m;
}

std::vector<Place::Cell> UprightCells(std::span<const Vec3f> points) {
  std::vector<uint32_t> heights(static_cast<size_t>(Place::kSide * Place::kSide), 0);
  for (const Vec3f& p : points) {
    if (!p.allFinite() || std::abs(p.x()) > kHalf_m || std::abs(p.y()) > kHalf_m) continue;
    const int x = CellAlong(static_cast<double>(p.x())), y = CellAlong(static_cast<double>(p.y()));
    const float bin = std::floor((p.z() - kLow_m) / kBin_m);
    if (!InPlan(x, y) || bin < 0.0f || bin >= static_cast<float>(kBins)) continue;
    heights[BitOf(x, y)] |= uint32_t{1} << static_cast<int>(bin);
  }
  std::vector<Place::Cell> cells;
  for (int y = 0; y < Place::kSide; ++y) {
    for (int x = 0; x < Place::kSide; ++x) {
      if (std::popcount(heights[BitOf(x, y)]) < kUprightBins) continue;
      cells.push_back({static_cast<int16_t>(x), static_cast<int16_t>(y)});
    }
  }
  return cells;
}

PlanBits CellsAndBeside(const std::vector<Place::Cell>& cells) {
  PlanBits bits = {};
  for (const Place::Cell& cell : cells) {
    for (int y = cell.y - 1; y <= cell.y + 1; ++y) {
      for (int x = cell.x - 1; x <= cell.x + 1; ++x) {
        if (InPlan(x, y)) bits[BitOf(x, y) / 64] |= uint64_t{1} << (BitOf(x, y) % 64);
      }
    }
  }
  return bits;
}

CoarseBits CoarseOf(const std::vector<Place::Cell>& cells) {
  CoarseBits bits = {};
  for (const Place::Cell& cell : cells) {
    if (!InPlan(cell.x, cell.y)) continue;
    bits[static_cast<size_t>(cell.y / Place::kCoarse)] |= uint64_t{1} << (cell.x / Place::kCoarse);
  }
  return bits;
}

/// e^(-2 pi i n / count), n from 0.
std::vector<std::complex<float>> UnitRoots(int count) {
  std::vector<std::complex<float>> roots(static_cast<size_t>(count));
  for (int n = 0; n < count; ++n) {
    const double angle = -2.0 * kPi * n / count;
    roots[static_cast<size_t>(n)] = {static_cast<float>(std::cos(angle)),
                                     static_cast<float>(std::sin(angle))};
  }
  return roots;
}

/// How many cells' centres project to each cell of a line at the angle, shared between the two nearest.
std::array<float, Place::kSide> Projection(const std::vector<Place::Cell>& cells, double angle) {
  std::array<float, Place::kSide> line = {};
  const double c = std::cos(angle), s = std::sin(angle);
  for (const Place::Cell& cell : cells) {
    const double at = (MiddleOf(cell.x) * c + MiddleOf(cell.y) * s + kHalf_m) / Place::kCell_m - 0.5;
    const double low = std::floor(at);
    const auto n = static_cast<int>(low);
    if (n < 0 || n + 1 >= Place::kSide) continue;  // the plan's corners
    const auto share = static_cast<float>(at - low);
    line[static_cast<size_t>(n)] += 1.0f - share;
    line[static_cast<size_t>(n) + 1] += share;
  }
  return line;
}

/// The plan's spectrum by the projection-slice theorem, a row an angle; square roots temper the strongest
/// waves. What does not turn with the plan is taken off.
std::vector<float> Magnitudes(const std::vector<Place::Cell>& cells) {
  static const std::vector<std::complex<float>> roots = UnitRoots(Place::kSide);
  std::vector<float> magnitude(static_cast<size_t>(Place::kAngles * Place::kWaves));
  std::array<float, Place::kWaves> mean = {};
  for (int angle = 0; angle < Place::kAngles; ++angle) {
    const auto line = Projection(cells, kPi * angle / Place::kAngles);
    for (int wave = 0; wave < Place::kWaves; ++wave) {
      std::complex<float> sum = 0.0f;
      for (size_t n = 0; n < line.size(); ++n) {
        sum += line[n] * roots[static_cast<size_t>(wave + 1) * n % line.size()];
      }
      const float root = std::sqrt(std::abs(sum));
      magnitude[static_cast<size_t>(angle * Place::kWaves + wave)] = root;
      mean[static_cast<size_t>(wave)] += root / Place::kAngles;
    }
  }
  for (size_t i = 0; i < magnitude.size(); ++i) magnitude[i] -= mean[i % Place::kWaves];
  return magnitude;
}

std::vector<float> TurnSpectrum(const std::vector<float>& magnitude) {
  static const std::vector<std::complex<float>> roots = UnitRoots(Place::kAngles);
  std::vector<float> spectrum(static_cast<size_t>(2 * Place::kTurns * Place::kWaves));
  float norm_sq = 0.0f;
  for (size_t wave = 0; wave < Place::kWaves; ++wave) {
    for (size_t turn = 0; turn < Place::kTurns; ++turn) {
      std::complex<float> sum = 0.0f;
      for (size_t angle = 0; angle < Place::kAngles; ++angle) {
        sum += magnitude[angle * Place::kWaves + wave] * roots[(turn + 1) * angle % Place::kAngles];
      }
      spectrum[(2 * wave) * Place::kTurns + turn] = sum.real();
      spectrum[(2 * wave + 1) * Place::kTurns + turn] = sum.imag();
      norm_sq += std::norm(sum);
    }
  }
  const float scale = norm_sq > 0.0f ? 1.0f / std::sqrt(norm_sq) : 0.0f;
  for (float& value : spectrum) value *= scale;
  return spectrum;
}

using TurnScores = std::array<float, Place::kAngles>;

/// A row a harmonic: its cosine and then its negative sine at each turn.
using TurnWaves = std::array<std::array<float, 2 * Place::kAngles>, Place::kTurns>;
TurnWaves MakeTurnWaves() {
  const std::vector<std::complex<float>> roots = UnitRoots(Place::kAngles);
  TurnWaves waves;
  for (size_t turn = 0; turn < Place::kTurns; ++turn) {
    for (size_t shift = 0; shift < Place::kAngles; ++shift) {
      const std::complex<float> root = roots[(turn + 1) * shift % Place::kAngles];
      waves[turn][shift] = root.real();
      waves[turn][Place::kAngles + shift] = root.imag();
    }
  }
  return waves;
}

/// Correlation of the candidate with the query turned by each multiple of 180 / kAngles degrees: at most 1.
TurnScores CorrelateTurns(const Place& candidate, const Place& query) {
  static const TurnWaves waves = MakeTurnWaves();
  std::array<float, Place::kTurns> real = {},
                                   imaginary = {};  // of the candidate's times the query's conjugate
  for (size_t wave = 0; wave < Place::kWaves; ++wave) {
    const float* a = &candidate.spectrum[2 * wave * Place::kTurns];
    const float* b = &query.spectrum[2 * wave * Place::kTurns];
    for (size_t turn = 0; turn < Place::kTurns; ++turn) {
      const float a_im = a[turn + Place::kTurns], b_im = b[turn + Place::kTurns];
      real[turn] += a[turn] * b[turn] + a_im * b_im;
      imaginary[turn] += a_im * b[turn] - a[turn] * b_im;
    }
  }
  TurnScores scores = {};
  for (size_t turn = 0; turn < Place::kTurns; ++turn) {
    const std::array<float, 2 * Place::kAngles>& wave = waves[turn];
    for (size_t shift = 0; shift < Place::kAngles; ++shift) {
      scores[shift] += real[turn] * wave[shift] + imaginary[turn] * wave[Place::kAngles + shift];
    }
  }
  return scores;
}

/// The best turn, and the best of those a sixth of a turn or more from it where it comes near: rooms of right
/// angles.
std::vector<size_t> BestTurns(const TurnScores& scores) {
  constexpr size_t kApart = Place::kAngles / 6;
  constexpr float kNear = 0.6f;
  const auto best = static_cast<size_t>(std::max_element(scores.begin(), scores.end()) - scores.begin());
  std::vector<size_t> turns = {best};
  size_t second = best;
  for (size_t off = kApart; off <= Place::kAngles - kApart; ++off) {
    const size_t at = (best + off) % Place::kAngles;
    if (second == best || scores[at] > scores[second]) second = at;
  }
  if (scores[second] > kNear * scores[best]) turns.push_back(second);
  return turns;
}

std::vector<Place::Cell> Turned(const std::vector<Place::Cell>& cells, double yaw_rad) {
  const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  std::vector<Place::Cell> turned;
  turned.reserve(cells.size());
  for (const Place::Cell& cell : cells) {
    const double x = MiddleOf(cell.x), y = MiddleOf(cell.y);
    turned.push_back(
        {static_cast<int16_t>(CellAlong(c * x - s * y)), static_cast<int16_t>(CellAlong(s * x + c * y))});
  }
  return turned;
}

struct CellShift {
  int x = 0, y = 0;
  int agreeing = -1;
};

/// Of coarse cells.
CellShift CoarseShift(const CoarseBits& candidate, const CoarseBits& query, int most) {
  CellShift best;
  for (int dy = -most; dy <= most; ++dy) {
    for (int dx = -most; dx <= most; ++dx) {
      int agreeing = 0;
      for (int y = std::max(0, -dy); y < std::min(Place::kCoarseSide, Place::kCoarseSide - dy); ++y) {
        const uint64_t row = query[static_cast<size_t>(y)];
        agreeing +=
            std::popcount((dx >= 0 ? row << dx : row >> -dx) & candidate[static_cast<size_t>(y + dy)]);
      }
      if (agreeing > best.agreeing) best = {dx, dy, agreeing};
    }
  }
  return best;
}

CellShift FineShift(const PlanBits& candidate, const std::vector<Place::Cell>& query,
                    const CellShift& coarse) {
  CellShift best;
  for (int dy = (coarse.y - 1) * Place::kCoarse; dy <= (coarse.y + 1) * Place::kCoarse; ++dy) {
    for (int dx = (coarse.x - 1) * Place::kCoarse; dx <= (coarse.x + 1) * Place::kCoarse; ++dx) {
      int agreeing = 0;
      for (const Place::Cell& cell : query) {
        const int x = cell.x + dx, y = cell.y + dy;
        agreeing += InPlan(x, y) && (candidate[BitOf(x, y) / 64] >> (BitOf(x, y) % 64) & 1) != 0;
      }
      if (agreeing > best.agreeing) best = {dx, dy, agreeing};
    }
  }
  return best;
}

/// The query's plan, turned, over the candidate's.
struct LaidPlan {
  double yaw_rad;
  std::vector<Place::Cell> cells;
  CellShift coarse;
};

LaidPlan LayOn(const Place& candidate, const Place& query, double yaw_rad, double max_shift_m) {
  const int most = static_cast<int>(max_shift_m / (Place::kCell_m * Place::kCoarse));
  LaidPlan plan{yaw_rad, Turned(query.cells, yaw_rad), {}};
  plan.coarse = CoarseShift(candidate.coarse, CoarseOf(plan.cells), most);
  return plan;
}

PlaceCandidate Fitted(const Place& candidate, const LaidPlan& plan) {
  const CellShift shift = FineShift(candidate.beside, plan.cells, plan.coarse);
  PlaceCandidate result;
  result.yaw_rad = core::WrapAngle(plan.yaw_rad);
  result.T_candidate_query =
      core::PoseFromXyzYaw(core::Vec3(shift.x * Place::kCell_m, shift.y * Place::kCell_m, 0.0), plan.yaw_rad);
  const auto sizes = static_cast<double>(candidate.cells.size() + plan.cells.size());
  result.distance = 1.0 - std::min(1.0, 2.0 * shift.agreeing / std::max(sizes, 1.0));
  return result;
}

/// The two best ways of those that the spectra leave open.
std::vector<PlaceCandidate> BestWays(const Place& candidate, const Place& query, const TurnScores& scores,
                                     double max_shift_m) {
  std::vector<LaidPlan> plans;
  for (const size_t turn : BestTurns(scores)) {
    for (const int half : {0, 1}) {
      const double yaw_rad = kPi * (static_cast<double>(turn) / Place::kAngles + half);
      plans.push_back(LayOn(candidate, query, yaw_rad, max_shift_m));
    }
  }
  std::stable_sort(plans.begin(), plans.end(), [](const LaidPlan& a, const LaidPlan& b) {
    return a.coarse.agreeing > b.coarse.agreeing;
  });
  return {Fitted(candidate, plans[0]), Fitted(candidate, plans[1])};
}

}  // namespace

PlaceDescriptor DescribePlace(std::span<const Vec3f> p_level) {
  return DescribePlan(UprightCells(p_level));
}

PlaceDescriptor DescribePlan(std::vector<Place::Cell> cells) {
  PlaceDescriptor place;
  place.cells = std::move(cells);
  place.beside = CellsAndBeside(place.cells);
  place.coarse = CoarseOf(place.cells);
  place.spectrum = TurnSpectrum(Magnitudes(place.cells));
  return place;
}

void PlaceDatabase::Add(uint32_t id, PlaceDescriptor place) {
  ids_.push_back(id);
  places_.push_back(std::move(place));
}

std::vector<PlaceCandidate> PlaceDatabase::Query(const PlaceDescriptor& place,
                                                 const PlaceQueryParams& params) const {
  struct Scored {
    float score;
    size_t index;
    TurnScores turns;
  };
  const size_t count = places_.size() - std::min(places_.size(), params.skip_youngest);
  std::vector<Scored> scored(count);
  for (size_t i = 0; i < count; ++i) {
    const TurnScores turns = CorrelateTurns(places_[i], place);
    scored[i] = {*std::max_element(turns.begin(), turns.end()), i, turns};
  }
  const size_t kept = std::min(count, params.verified);
  std::partial_sort(scored.begin(), scored.begin() + static_cast<std::ptrdiff_t>(kept), scored.end(),
                    [](const Scored& a, const Scored& b) {
                      return a.score != b.score ? a.score > b.score : a.index < b.index;
                    });
  std::vector<PlaceCandidate> candidates;
  for (size_t k = 0; k < kept; ++k) {
    const size_t index = scored[k].index;
    for (PlaceCandidate& way : BestWays(places_[index], place, scored[k].turns, params.max_shift_m)) {
      way.id = ids_[index];
      if (way.distance <= params.max_distance) candidates.push_back(way);
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const PlaceCandidate& a, const PlaceCandidate& b) { return a.distance < b.distance; });
  return candidates;
}

}  // namespace atlas::mapping
