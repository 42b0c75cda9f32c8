// The builders of the catalogue's localisers, declared from its lines.
#pragma once

#include <memory>

#include "mapping/slam/localiser.h"

namespace atlas::mapping {

#define X(name, builder, doc)                                                                       \
  std::unique_ptr<Localiser> builder(const LocalisationParams& params, const LocaliserStart& start, \
                                     const core::Rng& rng);
#include "mapping/slam/catalog.inc"
#undef X

}  // namespace atlas::mapping
