#include "mapping/io/map_file.h"

#include <fmt/format.h>
#include <zstd.h>

#include <cmath>
#include <fstream>
#include <memory>

#include "core/byte_reader.h"
#include "core/checksum.h"
#include "core/errors.h"
#include "core/files.h"
#include "mapping/io/map_codec.h"

// Header: magic, version, field (uint32), resolution (float64), chunks, fine leaves, coarse leaves, known
// uniform blocks (uint64), box of the chunks' keys (2 x 3 int32), CRC-64 of all that.
// Frames: chunks, bytes unpacked, bytes packed (uint32), CRC-64 of the packed bytes, those bytes (zstd).
// End: CRC-64 of the whole file before it.

namespace atlas::mapping {
namespace {

constexpr std::string_view kMagic = "SEATLAS\n";
constexpr uint32_t kChunksPerFrame = 64;
constexpr size_t kFullFrameBytes = size_t{1} << 20;  // a frame that is this long takes no further chunk
constexpr size_t kMaxFrameBytes = kFullFrameBytes + MaxChunkBytes<TsdfField>();
constexpr uint64_t kMaxChunks = uint64_t{1} << 32;
constexpr int kCompressionLevel = 3;

template <typename Field>
constexpr uint32_t kFieldCode = std::is_same_v<Field, OccupancyField> ? 0 : 1;

struct Header {
  uint32_t field = 0;
  double resolution_m = 0.0;
  uint64_t chunks = 0, fine = 0, coarse = 0, uniform = 0;
  NodeKey min, max;

  void Add(const NodeKey& key, const ChunkContent& content) {
    min = chunks == 0 ? key : NodeKey{std::min(min.x, key.x), std::min(min.y, key.y), std::min(min.z, key.z)};
    max = chunks == 0 ? key : NodeKey{std::max(max.x, key.x), std::max(max.y, key.y), std::max(max.z, key.z)};
    ++chunks;
    fine += content.fine_count;
    coarse += content.coarse_count;
    uniform += content.uniform_count;
  }
};

template <typename... T>
void Append(std::string* out, T... values) {
  (out->append(reinterpret_cast<const char*>(&values), sizeof(values)), ...);
}

std::string ToBytes(const Header& h) {
  std::string bytes(kMagic);
  Append(&bytes, kMapFileVersion, h.field, h.resolution_m, h.chunks, h.fine, h.coarse, h.uniform);
  for (const NodeKey& key : {h.min, h.max}) Append(&bytes, key.x, key.y, key.z);
  Append(&bytes, core::Crc64(bytes));
  return bytes;
}

/// Writes what it is given and remembers its checksum.
class CheckedFile {
 public:
  explicit CheckedFile(const std::filesystem::path& path) : file_(path) {}
  void Write(std::string_view bytes) {
    crc_ = core::Crc64(bytes, crc_);
    file_.Write(bytes);
  }
  void Finish() {
    std::string end;
    Append(&end, crc_);
    file_.Write(end);
    file_.Commit();
  }

 private:
  core::AtomicFile file_;
  uint64_t crc_ = 0;
};

struct FreeContext {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
};

/// Packs chunks into frames.
class FrameWriter {
 public:
  explicit FrameWriter(CheckedFile* file) : file_(file), context_(ZSTD_createCCtx()) {}

  template <typename Field>
  void Add(const Octree<Field>& map, const typename Octree<Field>::Chunk& chunk) {
    AppendChunk(map, chunk, &raw_);
    if (++chunks_ == kChunksPerFrame || raw_.size() >= kFullFrameBytes) Flush();
  }
  void Flush() {
    if (chunks_ == 0) return;
    packed_.resize(ZSTD_compressBound(raw_.size()));
    const size_t size = ZSTD_compressCCtx(context_.get(), packed_.data(), packed_.size(), raw_.data(),
                                          raw_.size(), kCompressionLevel);
    if (ZSTD_isError(size) != 0) throw std::runtime_error(ZSTD_getErrorName(size));
    packed_.resize(size);
    std::string head;
    Append(&head, chunks_, static_cast<uint32_t>(raw_.size()), static_cast<uint32_t>(size),
           core::Crc64(packed_));
    file_->Write(head);
    file_->Write(packed_);
    raw_.clear();
    chunks_ = 0;
  }

 private:
  CheckedFile* file_;
  std::unique_ptr<ZSTD_CCtx, FreeContext> context_;
  std::string raw_, packed_;
  uint32_t chunks_ = 0;
};

void CheckMagicAndVersion(core::ByteReader* reader, std::string_view bytes) {
  if (!bytes.starts_with(kMagic)) {
    reader->Fail(
        fmt::format("not a map file: does not begin with SEATLAS and a line feed ({} bytes)", bytes.size()));
  }
  reader->Take(kMagic.size());
  const auto version = reader->Next<uint32_t>();
  if (version == 0) reader->Fail("format version 0, must be 1 or more");
  if (version > kMapFileVersion) {
    reader->Fail(fmt::format("written by a newer version: format {}, this program reads up to {}", version,
                             kMapFileVersion));
  }
}

void CheckCrc(core::ByteReader* reader, std::string_view checked, std::string_view what) {
  const auto stored = reader->Next<uint64_t>();
  const uint64_t measured = core::Crc64(checked);
  if (stored != measured) {
    reader->Fail(
        fmt::format("damaged: checksum of the {} is {:016x}, must be {:016x}", what, measured, stored));
  }
}

NodeKey ReadKey(core::ByteReader* reader) {
  NodeKey key;
  key.x = reader->Next<int32_t>();
  key.y = reader->Next<int32_t>();
  key.z = reader->Next<int32_t>();
  return key;
}

Header ReadHeader(core::ByteReader* reader, std::string_view bytes) {
  CheckMagicAndVersion(reader, bytes);
  Header h;
  h.field = reader->Next<uint32_t>();
  h.resolution_m = reader->Next<double>();
  h.chunks = reader->Next<uint64_t>();
  h.fine = reader->Next<uint64_t>();
  h.coarse = reader->Next<uint64_t>();
  h.uniform = reader->Next<uint64_t>();
  h.min = ReadKey(reader);
  h.max = ReadKey(reader);
  CheckCrc(reader, bytes.substr(0, reader->position()), "header");
  if (h.field > 1) reader->Fail(fmt::format("field {}, must be 0 (occupancy) or 1 (tsdf)", h.field));
  if (!(h.resolution_m >= 0.001 && h.resolution_m <= 10.0)) {
    reader->Fail(fmt::format("resolution {} m, must be 0.001 to 10", h.resolution_m));
  }
  if (h.chunks > kMaxChunks) reader->Fail(fmt::format("{} chunks, at most {}", h.chunks, kMaxChunks));
  return h;
}

template <typename Field>
void ReadFrame(core::ByteReader* reader, uint64_t* first_code, std::string* raw, Octree<Field>* map,
               Header* seen) {
  const size_t begin = reader->position();
  const auto fail = [&](const std::string& reason) {
    reader->Fail(fmt::format("frame at byte {}: {}", begin, reason));
  };
  const auto chunks = reader->Next<uint32_t>();
  const auto raw_bytes = reader->Next<uint32_t>();
  const auto packed_bytes = reader->Next<uint32_t>();
  if (chunks == 0 || chunks > kChunksPerFrame) {
    fail(fmt::format("{} chunks, must be 1 to {}", chunks, kChunksPerFrame));
  }
  if (raw_bytes > kMaxFrameBytes) fail(fmt::format("{} bytes, at most {}", raw_bytes, kMaxFrameBytes));
  const auto stored = reader->Next<uint64_t>();
  const std::string_view packed = reader->Take(packed_bytes);
  if (const uint64_t measured = core::Crc64(packed); stored != measured) {
    fail(fmt::format("damaged: checksum is {:016x}, must be {:016x}", measured, stored));
  }
  raw->resize(raw_bytes);
  const size_t size = ZSTD_decompress(raw->data(), raw->size(), packed.data(), packed.size());
  if (ZSTD_isError(size) != 0 || size != raw_bytes) {
    fail(fmt::format("does not unpack to {} bytes ({})", raw_bytes,
                     ZSTD_isError(size) != 0 ? ZSTD_getErrorName(size) : std::to_string(size)));
  }
  core::ByteReader inner(*raw, fmt::format("{}: frame at byte {}", reader->file(), begin));
  for (uint32_t i = 0; i < chunks; ++i) {
    const ChunkContent content = ReadChunk(&inner, first_code, map);
    seen->Add(ChunkKeyOf(*first_code - 1), content);
  }
  if (inner.remaining() > 0) fail(fmt::format("{} bytes after its last chunk", inner.remaining()));
}

template <typename Field>
Octree<Field> ReadBody(core::ByteReader* reader, std::string_view bytes, const Header& header) {
  Octree<Field> map(header.resolution_m);
  Header seen;
  const auto match = [&](std::string_view what, uint64_t announced, uint64_t there) {
    if (announced != there) reader->Fail(fmt::format("{} {} announced, {} there", announced, what, there));
  };
  std::string raw;
  for (uint64_t first_code = 0; seen.chunks < header.chunks;) {
    if (reader->remaining() <= sizeof(uint64_t)) match("chunks", header.chunks, seen.chunks);
    ReadFrame(reader, &first_code, &raw, &map, &seen);
  }
  match("chunks", header.chunks, seen.chunks);
  match("fine leaves", header.fine, seen.fine);
  match("coarse leaves", header.coarse, seen.coarse);
  match("uniform blocks", header.uniform, seen.uniform);
  if (header.min != seen.min || header.max != seen.max)
    reader->Fail("bounds differ from those of its chunks");
  CheckCrc(reader, bytes.substr(0, reader->position()), "file");
  if (reader->remaining() > 0) reader->Fail(fmt::format("{} bytes after its end", reader->remaining()));
  return map;
}

}  // namespace

template <typename Field>
void WriteMap(const std::filesystem::path& path, const Octree<Field>& map) {
  const auto chunks = map.Chunks();
  Header header;
  header.field = kFieldCode<Field>;
  header.resolution_m = map.resolution_m();
  for (const auto* chunk : chunks) {
    if (const ChunkContent content = ContentOf(map, *chunk); content.any()) header.Add(chunk->key, content);
  }
  CheckedFile file(path);
  file.Write(ToBytes(header));
  FrameWriter frames(&file);
  for (const auto* chunk : chunks) {
    if (ContentOf(map, *chunk).any()) frames.Add(map, *chunk);
  }
  frames.Flush();
  file.Finish();
}

AnyOctree ParseMap(std::string_view bytes, const std::string& file) {
  core::ByteReader reader(bytes, file);
  const Header header = ReadHeader(&reader, bytes);
  if (header.field == kFieldCode<OccupancyField>) return ReadBody<OccupancyField>(&reader, bytes, header);
  return ReadBody<TsdfField>(&reader, bytes, header);
}

AnyOctree ReadMap(const std::filesystem::path& path) {
  return ParseMap(core::ReadFile(path), path.string());
}

bool IsMapFile(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;
  std::ifstream in(path, std::ios::binary);
  std::string magic(kMagic.size(), '\0');
  in.read(magic.data(), static_cast<std::streamsize>(magic.size()));
  return in && magic == kMagic;
}

template void WriteMap(const std::filesystem::path&, const OccupancyOctree&);
template void WriteMap(const std::filesystem::path&, const TsdfOctree&);

}  // namespace atlas::mapping
