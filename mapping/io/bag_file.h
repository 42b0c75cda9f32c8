// ROS 1 bags (format 2.0): which messages they hold, and the bytes of each.
//
// Read here rather than by librosbag, which trusts the offsets that a file tells: a damaged bag ends in an
// InputError, and a bag is read whether ROS is installed or not.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace atlas::mapping {

struct BagConnection {
  uint32_t id = 0;
  std::string topic;
  std::string type;  ///< "sensor_msgs/PointCloud2"
};

struct BagMessage {
  uint32_t connection = 0;  ///< BagConnection::id
  uint32_t chunk = 0;       ///< in the file's order
  uint32_t offset = 0;      ///< of the message's record in the chunk
  double time_s = 0.0;      ///< when it was recorded
};

/// Of an open bag only the index lies in memory, and the chunk that was last unpacked. Members may be called
/// from several threads.
class BagFile {
 public:
  /// @throws InputError "FILE: reason": another magic or version, a bag that was not closed, an end that
  /// comes early, records that contradict each other.
  explicit BagFile(const std::filesystem::path& path);
  ~BagFile();

  const std::vector<BagConnection>& connections() const;
  /// Of these connections, by chunk and offset.
  std::vector<BagMessage> MessagesOf(const std::vector<uint32_t>& connections) const;
  /// The serialised message, or its first `most` bytes. @throws InputError where the chunk is damaged.
  std::string Read(const BagMessage& message, size_t most = SIZE_MAX) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace atlas::mapping
