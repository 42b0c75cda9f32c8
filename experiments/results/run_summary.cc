#include "experiments/results/run_summary.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "core/errors.h"
#include "core/files.h"
#include "core/safe_text.h"

namespace atlas::experiments {
namespace {

using Json = nlohmann::ordered_json;
using core::InputError;

constexpr std::array<std::string_view, 6> kStatusNames = {"completed", "budget",      "robot_fell",
                                                          "stuck",     "interrupted", "failed"};
constexpr std::array<std::string_view, 14> kReasonNames = {
    "gain_exhausted", "surface_flat", "explored",        "route_done",   "blocked_narrow",
    "scan_budget",    "time_budget",  "distance_budget", "out_of_reach", "no_candidates",
    "fell",           "stuck",        "signal",          "error"};

template <typename Enum, size_t N>
std::optional<Enum> FromName(const std::array<std::string_view, N>& names, std::string_view name) {
  for (size_t i = 0; i < N; ++i) {
    if (names[i] == name) return static_cast<Enum>(i);
  }
  return std::nullopt;
}

/// Six decimals are as good as any measurement here; counts stay whole.
void Put(Json* json, const std::string& key, const core::Cell& cell) {
  if (const auto* number = std::get_if<double>(&cell)) {
    if (std::isfinite(*number)) (*json)[key] = std::stod(fmt::format("{:.6f}", *number));
  } else if (const auto* count = std::get_if<int64_t>(&cell)) {
    (*json)[key] = *count;
  } else if (const auto* flag = std::get_if<bool>(&cell)) {
    (*json)[key] = *flag;
  } else if (std::holds_alternative<std::string>(cell)) {
    throw std::logic_error("summary.json: " + key + ": a metric's word, which no reader takes");
  }
}

/// Reads typed values, naming origin and key when one is not what it should be.
class Reader {
 public:
  Reader(const std::string& text, const std::string& origin) : origin_(origin) {
    json_ = Json::parse(text, nullptr, false);
    if (json_.is_discarded() || !json_.is_object()) Fail("not a JSON object (file cut short?)");
  }

  void Text(const char* key, std::string* value) const {
    if (!json_.contains(key)) return;
    if (!json_[key].is_string()) Fail(fmt::format("{}: expected text, found {}", key, json_[key].dump()));
    *value = json_[key].get<std::string>();
    core::RefuseControlCharacters(*value, origin_ + ": " + key);
  }
  /// All other keys hold numbers, counts or flags.
  void Numbers(const std::set<std::string>& words, core::Row* row) const {
    for (const auto& [key, value] : json_.items()) {
      if (words.contains(key)) continue;
      if (value.is_number_integer()) {
        row->Set(key, core::Cell(value.get<int64_t>()));
      } else if (value.is_number()) {
        row->Set(key, value.get<double>());
      } else if (value.is_boolean()) {
        row->Set(key, value.get<bool>());
      } else {
        Fail(fmt::format("{}: expected a number, found {}", core::Printable(key), value.dump()));
      }
    }
  }
  void Seed(uint64_t* value) const {
    if (!json_.contains("seed")) return;
    if (!json_["seed"].is_number_unsigned())
      Fail(fmt::format("seed: expected >= 0, found {}", json_["seed"].dump()));
    *value = json_["seed"].get<uint64_t>();
  }
  [[noreturn]] void Fail(const std::string& what) const { throw InputError(origin_ + ": " + what); }

 private:
  std::string origin_;
  Json json_;
};

}  // namespace

std::string_view NameOf(RunStatus status) {
  return kStatusNames[static_cast<size_t>(status)];
}
std::string_view NameOf(StopReason reason) {
  return kReasonNames[static_cast<size_t>(reason)];
}
std::optional<RunStatus> RunStatusFromName(std::string_view name) {
  return FromName<RunStatus>(kStatusNames, name);
}
std::optional<StopReason> StopReasonFromName(std::string_view name) {
  return FromName<StopReason>(kReasonNames, name);
}

bool IsFinal(RunStatus status) {
  return status != RunStatus::kInterrupted && status != RunStatus::kFailed;
}

int ExitCodeOf(RunStatus status) {
  if (status == RunStatus::kCompleted || status == RunStatus::kBudget) return 0;
  return status == RunStatus::kInterrupted ? 130 : 1;
}

std::string ToJson(const RunSummary& summary) {
  Json json;
#define X(key) \
  if (!summary.key.empty()) json[#key] = summary.key;
  ATLAS_SUMMARY_TEXT(X)
  json["seed"] = summary.seed;
  ATLAS_SUMMARY_TEXT_MORE(X)
#undef X
  json["status"] = NameOf(summary.status);
  json["stop_reason"] = NameOf(summary.stop_reason);
  if (!summary.blocked_at.empty()) json["blocked_at"] = summary.blocked_at;
  for (const auto& [key, cell] : summary.numbers.cells()) Put(&json, key, cell);
  return json.dump(2) + "\n";
}

RunSummary SummaryFromJson(const std::string& text, const std::string& origin) {
  const Reader reader(text, origin);
  RunSummary summary;
  std::set<std::string> words = {"seed", "status", "stop_reason", "blocked_at"};
#define X(key)                     \
  reader.Text(#key, &summary.key); \
  words.insert(#key);
  ATLAS_SUMMARY_TEXT(X)
  ATLAS_SUMMARY_TEXT_MORE(X)
#undef X
  reader.Seed(&summary.seed);
  reader.Text("blocked_at", &summary.blocked_at);
  reader.Numbers(words, &summary.numbers);
  if (summary.experiment.empty()) reader.Fail("experiment: missing");
  std::string status, reason;
  reader.Text("status", &status);
  reader.Text("stop_reason", &reason);
  const auto known_status = RunStatusFromName(status);
  if (!known_status) reader.Fail(fmt::format("status: unknown value '{}'", status));
  summary.status = *known_status;
  const auto known_reason = StopReasonFromName(reason);
  if (!known_reason) reader.Fail(fmt::format("stop_reason: unknown value '{}'", reason));
  summary.stop_reason = *known_reason;
  return summary;
}

RunSummary LoadRunSummary(const std::filesystem::path& run_folder) {
  const std::filesystem::path path = run_folder / "summary.json";
  return SummaryFromJson(core::ReadFile(path), path.string());
}

}  // namespace atlas::experiments
