#include "core/errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>

#include "core/safe_text.h"

namespace atlas::core {
namespace {

size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t substitute = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substitute});
    }
  }
  return row.back();
}

std::string OneLine(std::string text) {
  while (text.ends_with(' ') || text.ends_with('\n') || text.ends_with('\r')) text.pop_back();
  return Printable(text);
}

}  // namespace

std::string NearestName(std::string_view name, const std::vector<std::string>& valid) {
  std::string best;
  size_t best_distance = std::max<size_t>(2, name.size() / 3) + 1;
  for (const std::string& candidate : valid) {
    const size_t distance = EditDistance(name, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

InputError::InputError(std::string message) : std::runtime_error(OneLine(std::move(message))) {}

std::string UnknownName(std::string_view kind, std::string_view name, const std::vector<std::string>& valid) {
  const std::string near = NearestName(name, valid);
  return fmt::format("unknown {} '{}'{} (valid: {})", kind, name,
                     near.empty() ? "" : fmt::format("; did you mean '{}'?", near), fmt::join(valid, ", "));
}

}  // namespace atlas::core
