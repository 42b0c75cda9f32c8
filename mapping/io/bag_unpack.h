// What the chunks of a bag are compressed with.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace atlas::mapping {

/// The `size` bytes that a bzip2 stream or an LZ4 frame unpacks to; none when it does not. Room is made as
/// the bytes come, not as `size` announces.
std::optional<std::string> Bz2Unpack(std::string_view packed, size_t size);
std::optional<std::string> Lz4Unpack(std::string_view packed, size_t size);

}  // namespace atlas::mapping
