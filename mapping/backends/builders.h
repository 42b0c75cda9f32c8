// The builders of the catalogue's maps, declared from its lines.
#pragma once

#include <memory>

#include "mapping/backends/catalog.h"

namespace atlas::mapping {

#define X(name, builder, doc) std::unique_ptr<Map> builder(const MapperParams& params, const MapSetup& setup);
#include "mapping/backends/catalog.inc"
#undef X

}  // namespace atlas::mapping
