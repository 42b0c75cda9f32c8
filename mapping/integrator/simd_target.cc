#include "mapping/integrator/simd_target.h"

#include <hwy/highway.h>

#include <array>
#include <utility>

#include "core/errors.h"

namespace atlas::mapping {
namespace {

// Better targets have lower bits.
const std::array<std::pair<const char*, int64_t>, 4> kTargets = {
    {{"scalar", HWY_BASELINE_SCALAR}, {"sse4", HWY_SSE4}, {"avx2", HWY_AVX2}, {"avx512", HWY_AVX3}}};

int64_t Available() {
  hwy::SetSupportedTargetsForTest(0);
  return hwy::SupportedTargets() | HWY_BASELINE_SCALAR;
}

}  // namespace

std::vector<std::string> SimdTargets() {
  const int64_t limit = hwy::SupportedTargets();
  const int64_t available = Available();
  hwy::SetSupportedTargetsForTest(limit == available ? 0 : limit);
  std::vector<std::string> names;
  for (const auto& [name, bit] : kTargets) {
    if (available & bit) names.emplace_back(name);
  }
  return names;
}

void LimitSimd(const std::string& target) {
  const int64_t available = Available();
  if (target.empty() || target == "best") return;
  for (const auto& [name, bit] : kTargets) {
    if (target != name) continue;
    if ((available & bit) == 0) throw core::InputError("SIMD target '" + target + "': not on this machine");
    int64_t allowed = 0;
    for (const auto& [other, other_bit] : kTargets) {
      if (other_bit >= bit && (available & other_bit)) allowed |= other_bit;
    }
    hwy::SetSupportedTargetsForTest(allowed);
    return;
  }
  throw core::InputError(core::UnknownName("SIMD target", target, SimdTargets()));
}

std::string SimdInUse() {
  const int64_t supported = hwy::SupportedTargets() | HWY_BASELINE_SCALAR;
  std::string best;
  for (const auto& [name, bit] : kTargets) {
    if (supported & bit) best = name;
  }
  return best;
}

}  // namespace atlas::mapping
