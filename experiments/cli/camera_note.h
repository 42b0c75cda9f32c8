// Whether what an experiment asks of this machine's renderer can be had.
#pragma once

#include <vector>

#include "core/params.h"

namespace atlas::experiments {

/// Says on standard error that the depth camera cannot start here, where `rows` ask for one and it cannot.
void TellOfMissingCamera(const std::vector<core::ParamRow>& rows);

}  // namespace atlas::experiments
