#include "mapping/io/bag_messages.h"

#include "core/byte_reader.h"
#include "mapping/io/cloud_channels.h"

namespace atlas::mapping {
namespace {

using core::ByteReader;
using core::Vec3;

constexpr double kFarthest_m = 1e7;
constexpr double kQuaternionTolerance = 0.01;

std::string_view NextText(ByteReader* reader) {
  return reader->Take(reader->Next<uint32_t>());
}

BagHeader NextHeader(ByteReader* reader) {
  reader->Next<uint32_t>();  // the sequence number
  const auto seconds = reader->Next<uint32_t>(), nanoseconds = reader->Next<uint32_t>();
  return {seconds + 1e-9 * static_cast<double>(nanoseconds), std::string(NextText(reader))};
}

core::Pose NextPose(ByteReader* reader) {
  double v[7];
  for (double& value : v) {
    value = reader->Next<double>();
    if (!std::isfinite(value)) reader->Fail("a pose is not finite");
  }
  const Vec3 p(v[0], v[1], v[2]);
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  if (p.norm() > kFarthest_m)
    reader->Fail(fmt::format("position is {:g} m from the origin (limit {:g})", p.norm(), kFarthest_m));
  if (!(std::abs(q.norm() - 1.0) <= kQuaternionTolerance))
    reader->Fail(
        fmt::format("length of the quaternion is {:g} (1 within {})", q.norm(), kQuaternionTolerance));
  return core::MakePose(q.normalized().toRotationMatrix(), p);
}

BagPose NextTransform(ByteReader* reader, bool has_child) {
  const BagHeader header = NextHeader(reader);
  BagPose pose{header.stamp_s, core::Pose::Identity(), header.frame, ""};
  if (has_child) pose.child_frame = NextText(reader);
  pose.pose = NextPose(reader);
  return pose;
}

/// sensor_msgs/PointField.
struct Field {
  std::string name;
  uint32_t offset = 0;
  uint8_t type = 0;  ///< 1 to 8: int8 uint8 int16 uint16 int32 uint32 float32 float64
  std::optional<Channel> channel;
};
constexpr size_t kTypeBytes[] = {0, 1, 1, 2, 2, 4, 4, 4, 8};

template <typename T>
double NumberAs(const char* bytes, bool in_order) {
  char raw[sizeof(T)];
  std::memcpy(raw, bytes, sizeof(T));
  if (!in_order) std::reverse(raw, raw + sizeof(T));
  T value;
  std::memcpy(&value, raw, sizeof(T));
  return static_cast<double>(value);
}

/// @pre the bytes of `type` are there.
double Number(uint8_t type, const char* bytes, bool in_order) {
  switch (type) {
    case 1:
      return NumberAs<int8_t>(bytes, in_order);
    case 2:
      return NumberAs<uint8_t>(bytes, in_order);
    case 3:
      return NumberAs<int16_t>(bytes, in_order);
    case 4:
      return NumberAs<uint16_t>(bytes, in_order);
    case 5:
      return NumberAs<int32_t>(bytes, in_order);
    case 6:
      return NumberAs<uint32_t>(bytes, in_order);
    case 7:
      return NumberAs<float>(bytes, in_order);
    default:
      return NumberAs<double>(bytes, in_order);
  }
}

struct Layout {
  uint32_t height = 0, width = 0, point_step = 0, row_step = 0;
  bool big_endian = false;
  std::vector<Field> fields;  ///< with a channel
  std::string_view data;
};

/// The fields that hold something known, each within a point.
void NextFields(ByteReader* reader, Layout* layout) {
  const auto count = reader->Next<uint32_t>();
  reader->Require(count, 13, "fields");
  bool has[kChannels] = {};
  for (uint32_t k = 0; k < count; ++k) {
    Field field;
    field.name = NextText(reader);
    field.offset = reader->Next<uint32_t>();
    field.type = reader->Next<uint8_t>();
    reader->Next<uint32_t>();  // values a point, of which the first counts
    field.channel = ChannelOf(field.name);
    if (!field.channel) continue;
    if (field.type < 1 || field.type > 8)
      reader->Fail(fmt::format("field '{}' is of type {} (1 to 8)", field.name, field.type));
    if (has[*field.channel]) reader->Fail(fmt::format("two fields for what '{}' holds", field.name));
    has[*field.channel] = true;
    layout->fields.push_back(std::move(field));
  }
  if (!has[kX] || !has[kY] || !has[kZ]) reader->Fail("the fields lack x, y or z");
}

Layout NextLayout(ByteReader* reader) {
  Layout layout;
  layout.height = reader->Next<uint32_t>();
  layout.width = reader->Next<uint32_t>();
  NextFields(reader, &layout);
  layout.big_endian = reader->Next<uint8_t>() != 0;
  layout.point_step = reader->Next<uint32_t>();
  layout.row_step = reader->Next<uint32_t>();
  layout.data = NextText(reader);
  return layout;
}

/// That all points lie in the data.
void Check(const Layout& layout, const ByteReader& reader) {
  constexpr uint64_t kMost = 2147483647;
  const uint64_t points = uint64_t{layout.height} * layout.width;
  if (layout.height > kMost || layout.width > kMost || points > kMost)
    reader.Fail(fmt::format("{} x {} points (limit {})", layout.height, layout.width, kMost));
  for (const Field& field : layout.fields) {
    if (uint64_t{field.offset} + kTypeBytes[field.type] > layout.point_step)
      reader.Fail(fmt::format("field '{}' ends at byte {} of points of {}", field.name,
                              uint64_t{field.offset} + kTypeBytes[field.type], layout.point_step));
  }
  const uint64_t row = uint64_t{layout.width} * layout.point_step;
  if (layout.height > 1 && layout.row_step < row)
    reader.Fail(fmt::format("rows of {} bytes hold {} points of {}", layout.row_step, layout.width,
                            layout.point_step));
  const uint64_t needs = points == 0 ? 0 : uint64_t{layout.height - 1} * layout.row_step + row;
  if (needs > layout.data.size())
    reader.Fail(fmt::format("{} x {} points need {} bytes, the data have {}", layout.height, layout.width,
                            needs, layout.data.size()));
}

}  // namespace

BagHeader ParseBagHeader(std::string_view bytes, const std::string& where) {
  ByteReader reader(bytes, where);
  return NextHeader(&reader);
}

RecordedCloud ParseCloudMessage(std::string_view bytes, const std::string& where) {
  ByteReader reader(bytes, where);
  NextHeader(&reader);
  const Layout layout = NextLayout(&reader);
  Check(layout, reader);
  RawCloud raw;
  bool has[kChannels] = {};
  for (const Field& field : layout.fields) {
    has[*field.channel] = true;
    if (*field.channel == kTime) raw.time_is_single = field.type == 7;
  }
  raw.Resize(size_t{layout.height} * layout.width, has);
  const bool in_order = layout.big_endian == (std::endian::native == std::endian::big);
  for (const Field& field : layout.fields) {
    size_t i = 0;
    for (size_t row = 0; row < layout.height; ++row) {
      const char* at = layout.data.data() + row * layout.row_step + field.offset;
      for (size_t column = 0; column < layout.width; ++column, at += layout.point_step)
        raw.Set(*field.channel, i++, Number(field.type, at, in_order));
    }
  }
  const bool organised = layout.height > 1 && layout.width > 0;
  const size_t points = raw.p.size();
  return FinishCloud(std::move(raw), organised ? static_cast<int>(layout.height) : 1,
                     organised ? static_cast<int>(layout.width) : static_cast<int>(points), organised, where);
}

bool IsPoseType(std::string_view type) {
  return type == "nav_msgs/Odometry" || type == "geometry_msgs/PoseStamped" ||
         type == "geometry_msgs/PoseWithCovarianceStamped" || type == "geometry_msgs/TransformStamped" ||
         type == "nav_msgs/Path";
}

std::vector<BagPose> ParsePoseMessage(std::string_view type, std::string_view bytes,
                                      const std::string& where) {
  ByteReader reader(bytes, where);
  if (type != "nav_msgs/Path")
    return {NextTransform(&reader, type == "nav_msgs/Odometry" || type == "geometry_msgs/TransformStamped")};
  NextHeader(&reader);
  const auto count = reader.Next<uint32_t>();
  reader.Require(count, 72, "poses");
  std::vector<BagPose> poses;
  for (uint32_t i = 0; i < count; ++i) poses.push_back(NextTransform(&reader, false));
  return poses;
}

bool IsTransformsType(std::string_view type) {
  return type == "tf2_msgs/TFMessage" || type == "tf/tfMessage";
}

std::vector<BagPose> ParseTransformsMessage(std::string_view bytes, const std::string& where) {
  ByteReader reader(bytes, where);
  const auto count = reader.Next<uint32_t>();
  reader.Require(count, 76, "transforms");
  std::vector<BagPose> transforms;
  for (uint32_t i = 0; i < count; ++i) transforms.push_back(NextTransform(&reader, true));
  return transforms;
}

}  // namespace atlas::mapping
