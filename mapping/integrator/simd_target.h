// Which SIMD instructions the integrator may use. The map is the same whatever they are.
#pragma once

#include <string>
#include <vector>

namespace atlas::mapping {

/// "scalar", "sse4", "avx2", "avx512", as far as this machine has them; best last.
std::vector<std::string> SimdTargets();

/// From now on the named target at most; "" or "best" lifts the limit. Process-wide: for benches and tests,
/// not while an integrator runs. @throws InputError for an unknown name or one that the machine lacks.
void LimitSimd(const std::string& target);

/// The target in use.
std::string SimdInUse();

}  // namespace atlas::mapping
