// LZF, the byte compression inside binary_compressed PCD files.
//
// A stream of: control byte c < 32: c + 1 literal bytes follow; else a copy of (c >> 5) + 2 bytes (where
// c >> 5 is 7, the next byte is added) from ((c & 31) << 8 | next byte) + 1 bytes before the end of the
// output.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace atlas::mapping {

/// The `size` bytes that `packed` unpacks to; none when it does not, without making room for more than a
/// stream of that length can hold.
std::optional<std::string> LzfUnpack(std::string_view packed, size_t size);
/// At most 3 % longer than `bytes`.
std::string LzfPack(std::string_view bytes);

}  // namespace atlas::mapping
