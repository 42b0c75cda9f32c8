// Damage of the kinds that files suffer, and of the kinds that break readers.
#pragma once

#include <string>
#include <vector>

#include "core/rng.h"

namespace atlas::fuzz {

/// One of `seeds` with one to four of: a flipped bit, a changed byte, a cut end, bytes lost, doubled or put
/// in, a piece of another seed, a number of the text replaced by an extreme one, an extreme number over the
/// bytes.
std::string Mutated(const std::vector<std::string>& seeds, core::Rng* rng);

}  // namespace atlas::fuzz
