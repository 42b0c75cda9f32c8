#include "mapping/io/bag_unpack.h"

#include <bzlib.h>
#include <lz4frame.h>

#include <algorithm>
#include <memory>

namespace atlas::mapping {
namespace {

/// Room for the next bytes of `out`, which ends at `size`.
size_t Grow(std::string* out, size_t have, size_t size) {
  constexpr size_t kFirstBytes = size_t{1} << 16;
  if (have == out->size()) out->resize(std::min(size, std::max(kFirstBytes, 2 * out->size())));
  return out->size() - have;
}

}  // namespace

std::optional<std::string> Bz2Unpack(std::string_view packed, size_t size) {
  bz_stream stream = {};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return std::nullopt;
  const std::unique_ptr<bz_stream, int (*)(bz_stream*)> end(&stream, BZ2_bzDecompressEnd);
  stream.next_in = const_cast<char*>(packed.data());
  stream.avail_in = static_cast<unsigned>(packed.size());
  std::string out;
  size_t have = 0;
  while (true) {
    const size_t room = Grow(&out, have, size);
    stream.next_out = out.data() + have;
    stream.avail_out = static_cast<unsigned>(room);
    const unsigned in_before = stream.avail_in;
    const int result = BZ2_bzDecompress(&stream);
    have += room - stream.avail_out;
    if (result == BZ_STREAM_END) break;
    const bool moved = stream.avail_in != in_before || stream.avail_out != room;
    if (result != BZ_OK || !moved) return std::nullopt;
  }
  if (have != size) return std::nullopt;
  return out;
}

std::optional<std::string> Lz4Unpack(std::string_view packed, size_t size) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION)) != 0) return std::nullopt;
  const std::unique_ptr<LZ4F_dctx, LZ4F_errorCode_t (*)(LZ4F_dctx*)> context(raw,
                                                                             LZ4F_freeDecompressionContext);
  std::string out;
  size_t have = 0;
  for (size_t left = 1; left != 0;) {
    size_t written = Grow(&out, have, size), taken = packed.size();
    left = LZ4F_decompress(raw, out.data() + have, &written, packed.data(), &taken, nullptr);
    if (LZ4F_isError(left) != 0 || (left != 0 && written == 0 && taken == 0)) return std::nullopt;
    have += written;
    packed.remove_prefix(taken);
  }
  if (have != size) return std::nullopt;
  return out;
}

}  // namespace atlas::mapping
