// Which program this is.
#pragma once

#include <string>

namespace atlas::experiments {

std::string Version();      ///< "0.1.0"
std::string VersionText();  ///< "atlas 0.1.0 (1a2b3c4)"

}  // namespace atlas::experiments
