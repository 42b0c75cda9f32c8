#include "mapping/io/bag_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <map>
#include <mutex>

#include "core/byte_reader.h"
#include "mapping/io/bag_unpack.h"

namespace atlas::mapping {
namespace {

using core::ByteReader;
using core::InputError;

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
constexpr uint32_t kMostHeaderBytes = 1u << 20;

enum Op : uint8_t {
  kMessage = 2,
  kBagHeader = 3,
  kIndexData = 4,
  kChunk = 5,
  kChunkInfo = 6,
  kConnection = 7
};

using Fields = std::map<std::string, std::string, std::less<>>;

/// name=value pairs, each after its length.
Fields ParseFields(std::string_view header, const std::string& where) {
  Fields fields;
  for (ByteReader reader(header, where); reader.remaining() > 0;) {
    const std::string_view field = reader.Take(reader.Next<uint32_t>());
    const size_t at = field.find('=');
    if (at == std::string_view::npos || at == 0) reader.Fail("a field of a record has no name");
    fields.emplace(field.substr(0, at), field.substr(at + 1));
  }
  return fields;
}

const std::string& TextOf(const Fields& fields, std::string_view name, const std::string& where) {
  const auto found = fields.find(name);
  if (found == fields.end()) throw InputError(fmt::format("{}: a record lacks its field '{}'", where, name));
  return found->second;
}

template <typename T>
T NumberOf(const Fields& fields, std::string_view name, const std::string& where) {
  const std::string& text = TextOf(fields, name, where);
  if (text.size() != sizeof(T)) {
    throw InputError(
        fmt::format("{}: field '{}' has {} bytes (needs {})", where, name, text.size(), sizeof(T)));
  }
  return ByteReader(text, where).Next<T>();
}

/// A file of which parts are read; never past its end.
class FileBytes {
 public:
  explicit FileBytes(const std::filesystem::path& path) : file_(path.string()) {
    std::error_code error;
    if (!std::filesystem::exists(path, error)) throw InputError(fmt::format("{}: no such file", file_));
    if (!std::filesystem::is_regular_file(path, error))
      throw InputError(fmt::format("{}: not a file", file_));
    descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat status = {};
    if (descriptor_ < 0 || ::fstat(descriptor_, &status) != 0)
      throw InputError(fmt::format("{}: cannot be read", file_));
    size_ = static_cast<uint64_t>(status.st_size);
  }
  ~FileBytes() { ::close(descriptor_); }
  FileBytes(const FileBytes&) = delete;
  FileBytes& operator=(const FileBytes&) = delete;

  uint64_t size() const { return size_; }
  const std::string& name() const { return file_; }

  void Require(uint64_t at, uint64_t count, std::string_view what) const {
    if (at <= size_ && count <= size_ - at) return;
    throw InputError(fmt::format("{}: ends early: {} bytes of {} announced at byte {}, the file has {}",
                                 file_, count, what, at, size_));
  }

  std::string Read(uint64_t at, uint64_t count, std::string_view what) const {
    Require(at, count, what);
    std::string bytes(count, '\0');
    for (uint64_t have = 0; have < count;) {
      const ssize_t got =
          ::pread(descriptor_, bytes.data() + have, count - have, static_cast<off_t>(at + have));
      if (got <= 0) throw InputError(fmt::format("{}: cannot be read at byte {}", file_, at + have));
      have += static_cast<uint64_t>(got);
    }
    return bytes;
  }

 private:
  std::string file_;
  int descriptor_ = -1;
  uint64_t size_ = 0;
};

struct Chunk {
  uint64_t first_byte = 0;
  uint64_t packed_bytes = 0;
  uint32_t bytes = 0;
  std::string compression;
};

}  // namespace

struct BagFile::Impl {
  explicit Impl(const std::filesystem::path& path) : file(path) {}

  FileBytes file;
  std::vector<BagConnection> connections;
  std::vector<Chunk> chunks;
  std::vector<BagMessage> messages;
  uint32_t connections_told = 0, chunks_told = 0;
  mutable std::mutex mutex;
  mutable size_t unpacked_chunk = SIZE_MAX;
  mutable std::shared_ptr<const std::string> unpacked;

  [[noreturn]] void Fail(const std::string& reason) const {
    throw InputError(fmt::format("{}: {}", file.name(), reason));
  }
  void CheckMagic() const;
  void ReadIndex();
  void AddRecord(const Fields& fields, uint64_t at, uint32_t bytes);
  void AddBagHeader(const Fields& fields);
  void AddChunk(const Fields& fields, uint64_t at, uint32_t bytes);
  void AddIndexData(const Fields& fields, const std::string& data);
  void AddConnection(const Fields& fields, const std::string& data);
  std::shared_ptr<const std::string> Unpacked(size_t chunk) const;
  std::string BytesOf(size_t chunk, uint64_t offset, uint64_t count) const;
};

void BagFile::Impl::CheckMagic() const {
  const std::string head = file.Read(0, std::min<uint64_t>(file.size(), kMagic.size()), "the version");
  if (head == kMagic) return;
  if (head.starts_with("#ROSBAG V") && head.size() >= 12)
    Fail(fmt::format("format {} of ROS bags (2.0 is read here; `rosbag fix` converts)", head.substr(9, 3)));
  Fail("not a ROS 1 bag");
}

/// Every record outside the chunks, from the first to the last.
void BagFile::Impl::ReadIndex() {
  CheckMagic();
  for (uint64_t at = kMagic.size(); at < file.size();) {
    const std::string& name = file.name();
    const auto header_bytes = ByteReader(file.Read(at, 4, "a record"), name).Next<uint32_t>();
    if (header_bytes > kMostHeaderBytes)
      Fail(fmt::format("the header of a record at byte {} has {} bytes (limit {})", at, header_bytes,
                       kMostHeaderBytes));
    const std::string head = file.Read(at + 4, uint64_t{header_bytes} + 4, "a record's header");
    ByteReader reader(head, name);
    const Fields fields = ParseFields(reader.Take(header_bytes), name);
    const auto data_bytes = reader.Next<uint32_t>();
    at += 8 + uint64_t{header_bytes};
    file.Require(at, data_bytes, "a record");
    if (chunks.empty() && connections.empty() && chunks_told == 0 && connections_told == 0 &&
        NumberOf<uint8_t>(fields, "op", name) != kBagHeader)
      Fail("the first record is not the bag's header");
    AddRecord(fields, at, data_bytes);
    at += data_bytes;
  }
  if (connections.size() != connections_told || chunks.size() != chunks_told) {
    Fail(fmt::format("{} connections and {} chunks, {} and {} by the header: the bag is damaged",
                     connections.size(), chunks.size(), connections_told, chunks_told));
  }
}

void BagFile::Impl::AddRecord(const Fields& fields, uint64_t at, uint32_t bytes) {
  const auto op = NumberOf<uint8_t>(fields, "op", file.name());
  switch (op) {
    case kBagHeader:
      return AddBagHeader(fields);
    case kChunk:
      return AddChunk(fields, at, bytes);
    case kIndexData:
      return AddIndexData(fields, file.Read(at, bytes, "an index"));
    case kConnection:
      return AddConnection(fields, file.Read(at, bytes, "a connection"));
    case kChunkInfo:
      return;
    default:
      Fail(fmt::format("record of kind {} before byte {}", op, at));
  }
}

void BagFile::Impl::AddBagHeader(const Fields& fields) {
  const auto index_at = NumberOf<uint64_t>(fields, "index_pos", file.name());
  if (index_at == 0) Fail("the bag was not closed and has no index (`rosbag reindex` makes one)");
  file.Require(index_at, 0, "the index");
  connections_told = NumberOf<uint32_t>(fields, "conn_count", file.name());
  chunks_told = NumberOf<uint32_t>(fields, "chunk_count", file.name());
}

void BagFile::Impl::AddChunk(const Fields& fields, uint64_t at, uint32_t bytes) {
  Chunk chunk{at, bytes, NumberOf<uint32_t>(fields, "size", file.name()),
              TextOf(fields, "compression", file.name())};
  if (chunk.compression != "none" && chunk.compression != "bz2" && chunk.compression != "lz4")
    Fail(fmt::format("compression of a chunk is '{}' (none, bz2 or lz4)", chunk.compression.substr(0, 20)));
  if (chunk.compression == "none" && chunk.bytes != bytes)
    Fail(fmt::format("a chunk of {} bytes tells {}", bytes, chunk.bytes));
  chunks.push_back(std::move(chunk));
}

void BagFile::Impl::AddIndexData(const Fields& fields, const std::string& data) {
  const auto version = NumberOf<uint32_t>(fields, "ver", file.name());
  if (version != 1) Fail(fmt::format("an index has version {} (1)", version));
  if (chunks.empty()) Fail("an index comes before any chunk");
  const auto connection = NumberOf<uint32_t>(fields, "conn", file.name());
  const auto count = NumberOf<uint32_t>(fields, "count", file.name());
  ByteReader reader(data, file.name());
  reader.Require(count, 12, "an index");
  for (uint32_t i = 0; i < count; ++i) {
    const auto seconds = reader.Next<uint32_t>(), nanoseconds = reader.Next<uint32_t>();
    const auto offset = reader.Next<uint32_t>();
    messages.push_back({connection, static_cast<uint32_t>(chunks.size() - 1), offset,
                        seconds + 1e-9 * static_cast<double>(nanoseconds)});
  }
}

void BagFile::Impl::AddConnection(const Fields& fields, const std::string& data) {
  const Fields about = ParseFields(data, file.name());
  BagConnection connection{NumberOf<uint32_t>(fields, "conn", file.name()),
                           TextOf(fields, "topic", file.name()), TextOf(about, "type", file.name())};
  const auto is_plain = [](char c) { return c > ' ' && c < 127; };
  for (const std::string* text : {&connection.topic, &connection.type}) {
    if (text->empty() || !std::all_of(text->begin(), text->end(), is_plain))
      Fail(fmt::format("connection {} has no proper topic and type", connection.id));
  }
  connections.push_back(std::move(connection));
}

std::shared_ptr<const std::string> BagFile::Impl::Unpacked(size_t index) const {
  const std::lock_guard lock(mutex);
  if (unpacked_chunk == index) return unpacked;
  const Chunk& chunk = chunks[index];
  const std::string packed = file.Read(chunk.first_byte, chunk.packed_bytes, "a chunk");
  auto bytes = chunk.compression == "bz2" ? Bz2Unpack(packed, chunk.bytes) : Lz4Unpack(packed, chunk.bytes);
  if (!bytes) Fail(fmt::format("chunk {}: the {} data are damaged", index, chunk.compression));
  unpacked = std::make_shared<const std::string>(std::move(*bytes));
  unpacked_chunk = index;
  return unpacked;
}

std::string BagFile::Impl::BytesOf(size_t index, uint64_t offset, uint64_t count) const {
  const Chunk& chunk = chunks[index];
  if (offset > chunk.bytes || count > chunk.bytes - offset)
    Fail(fmt::format("chunk {} ends early: {} bytes of a message announced at byte {} of {}", index, count,
                     offset, chunk.bytes));
  if (chunk.compression == "none") return file.Read(chunk.first_byte + offset, count, "a message");
  return Unpacked(index)->substr(offset, count);
}

BagFile::BagFile(const std::filesystem::path& path) : impl_(std::make_unique<Impl>(path)) {
  impl_->ReadIndex();
}

BagFile::~BagFile() = default;

const std::vector<BagConnection>& BagFile::connections() const {
  return impl_->connections;
}

std::vector<BagMessage> BagFile::MessagesOf(const std::vector<uint32_t>& connections) const {
  std::vector<BagMessage> messages;
  for (const BagMessage& m : impl_->messages) {
    if (std::find(connections.begin(), connections.end(), m.connection) != connections.end())
      messages.push_back(m);
  }
  std::sort(messages.begin(), messages.end(), [](const BagMessage& a, const BagMessage& b) {
    return std::pair(a.chunk, a.offset) < std::pair(b.chunk, b.offset);
  });
  return messages;
}

std::string BagFile::Read(const BagMessage& message, size_t most) const {
  const std::string& name = impl_->file.name();
  const auto number = [&](uint64_t offset) {
    return ByteReader(impl_->BytesOf(message.chunk, offset, 4), name).Next<uint32_t>();
  };
  const uint32_t header_bytes = number(message.offset);
  const uint64_t header_at = uint64_t{message.offset} + 4, data_at = header_at + header_bytes + 4;
  const Fields fields = ParseFields(impl_->BytesOf(message.chunk, header_at, header_bytes), name);
  if (NumberOf<uint8_t>(fields, "op", name) != kMessage ||
      NumberOf<uint32_t>(fields, "conn", name) != message.connection)
    impl_->Fail(fmt::format("chunk {}: no message at byte {} where the index tells one", message.chunk,
                            message.offset));
  const uint32_t data_bytes = number(data_at - 4);
  impl_->BytesOf(message.chunk, data_at + data_bytes, 0);
  return impl_->BytesOf(message.chunk, data_at, std::min<uint64_t>(data_bytes, most));
}

}  // namespace atlas::mapping
