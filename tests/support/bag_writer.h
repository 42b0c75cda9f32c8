// Small uncompressed ROS 1 bags and the messages in them, byte by byte as the format tells.
#pragma once

#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <string>
#include <vector>

namespace atlas::tests {

template <typename T>
std::string Raw(T value) {
  std::string raw(sizeof(T), '\0');
  std::memcpy(raw.data(), &value, sizeof(T));
  return raw;
}

inline std::string Sized(const std::string& bytes) {
  return Raw(static_cast<uint32_t>(bytes.size())) + bytes;
}

/// One chunk with all messages, its indices, then connections and the chunk's summary.
class BagWriter {
 public:
  /// A message of `topic`, whose type the first message of it tells.
  void Add(const std::string& topic, const std::string& type, uint32_t seconds, const std::string& message) {
    size_t id = 0;
    while (id < topics_.size() && topics_[id] != topic) ++id;
    if (id == topics_.size()) {
      topics_.push_back(topic);
      connections_ += Connection(id, topic, type);
      indices_.emplace_back();
      counts_.push_back(0);
    }
    indices_[id] += Raw(seconds) + Raw(uint32_t{0}) + Raw(static_cast<uint32_t>(chunk_.size()));
    ++counts_[id];
    chunk_ +=
        Record({Op(2), "conn=" + Raw(static_cast<uint32_t>(id)), "time=" + Raw(uint64_t{seconds})}, message);
  }

  std::string Bytes(bool closed = true) const {
    const std::string magic = "#ROSBAG V2.0\n";
    std::string body =
        Record({Op(5), "compression=none", "size=" + Raw(static_cast<uint32_t>(chunk_.size()))}, chunk_);
    for (size_t id = 0; id < topics_.size(); ++id) {
      body += Record({Op(4), "ver=" + Raw(uint32_t{1}), "conn=" + Raw(static_cast<uint32_t>(id)),
                      "count=" + Raw(counts_[id])},
                     indices_[id]);
    }
    const size_t header_bytes = Header(0).size();
    const uint64_t index_at = magic.size() + header_bytes + body.size();
    return magic + Header(closed ? index_at : 0) + body + (closed ? connections_ : "");
  }

 private:
  static std::string Op(uint8_t op) { return "op=" + Raw(op); }
  static std::string Record(std::initializer_list<std::string> fields, const std::string& data) {
    std::string header;
    for (const std::string& field : fields) header += Sized(field);
    return Sized(header) + Sized(data);
  }
  static std::string Connection(size_t id, const std::string& topic, const std::string& type) {
    return Record({Op(7), "conn=" + Raw(static_cast<uint32_t>(id)), "topic=" + topic},
                  Sized("topic=" + topic) + Sized("type=" + type) + Sized("md5sum=*"));
  }
  std::string Header(uint64_t index_at) const {
    return Record(
        {Op(3), "index_pos=" + Raw(index_at), "conn_count=" + Raw(static_cast<uint32_t>(topics_.size())),
         "chunk_count=" + Raw(uint32_t{1})},
        "    ");
  }

  std::vector<std::string> topics_, indices_;
  std::vector<uint32_t> counts_;
  std::string chunk_, connections_;
};

inline std::string BagHeaderBytes(uint32_t seconds, const std::string& frame) {
  return Raw(uint32_t{7}) + Raw(seconds) + Raw(uint32_t{0}) + Sized(frame);
}

/// sensor_msgs/PointCloud2 of float32 x y z and uint32 t (ns).
inline std::string CloudMessage(uint32_t seconds, uint32_t height, uint32_t width,
                                const std::vector<float>& xyz) {
  std::string fields, data;
  const char* const names[] = {"x", "y", "z", "t"};
  for (uint32_t k = 0; k < 4; ++k)
    fields += Sized(names[k]) + Raw(4 * k) + Raw(static_cast<uint8_t>(k < 3 ? 7 : 6)) + Raw(uint32_t{1});
  for (size_t i = 0; i < xyz.size(); i += 3)
    data += Raw(xyz[i]) + Raw(xyz[i + 1]) + Raw(xyz[i + 2]) + Raw(static_cast<uint32_t>(i * 1000000));
  return BagHeaderBytes(seconds, "lidar") + Raw(height) + Raw(width) + Raw(uint32_t{4}) + fields +
         Raw(uint8_t{0}) + Raw(uint32_t{16}) + Raw(16 * width) + Sized(data) + Raw(uint8_t{1});
}

inline std::string PoseBytes(double x, double qw = 1.0) {
  std::string bytes;
  for (const double v : {x, 0.0, 0.0, 0.0, 0.0, 0.0, qw}) bytes += Raw(v);
  return bytes;
}

}  // namespace atlas::tests
