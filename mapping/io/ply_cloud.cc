#include <fmt/format.h>

#include "core/byte_reader.h"
#include "core/ply_format.h"
#include "mapping/io/cloud_channels.h"

namespace atlas::mapping {
namespace {

using core::InputError;
using Channels = std::vector<std::optional<Channel>>;

Channels ChannelsOf(const core::PlyElement& element, RawCloud* raw) {
  bool has[kChannels] = {};
  Channels channels;
  for (const core::PlyProperty& property : element.properties) {
    auto channel = property.is_list ? std::nullopt : ChannelOf(property.name);
    if (channel && has[*channel])
      throw InputError(fmt::format("two properties for what '{}' holds", property.name));
    if (channel) has[*channel] = true;
    if (channel == kTime) raw->time_is_single = property.type == core::PlyScalar::kFloat;
    channels.push_back(channel);
  }
  if (!has[kX] || !has[kY] || !has[kZ]) throw InputError("the vertices lack x, y or z");
  raw->Resize(element.count, has);
  return channels;
}

void ReadVertices(const core::PlyElement& element, core::PlyValues* values, RawCloud* raw) {
  if (element.count > values->Capacity(element) || element.count > 2147483647) {
    throw InputError(fmt::format("ends early: {} vertices announced, at most {} fit", element.count,
                                 values->Capacity(element)));
  }
  const Channels channels = ChannelsOf(element, raw);
  for (size_t i = 0; i < element.count; ++i) {
    for (size_t k = 0; k < channels.size(); ++k) {
      const core::PlyProperty& property = element.properties[k];
      const double value = values->Next(property.is_list ? property.count_type : property.type);
      if (channels[k]) raw->Set(*channels[k], i, value);
      for (double rest = 0; property.is_list && rest < value; ++rest) values->Next(property.type);
    }
  }
}

RawCloud ReadRaw(std::string_view bytes) {
  const core::PlyHeader header = core::ReadPlyHeader(bytes);
  core::PlyValues values(bytes, header);
  RawCloud raw;
  for (const core::PlyElement& element : header.elements) {
    if (element.name == "vertex") {
      ReadVertices(element, &values, &raw);
      return raw;
    }
    for (size_t i = 0; i < element.count && !element.properties.empty(); ++i) values.Skip(element);
  }
  throw InputError("no vertices in the PLY header");
}

}  // namespace

RecordedCloud ParsePlyCloud(std::string_view bytes, const std::string& file) {
  RawCloud raw;
  try {
    raw = ReadRaw(bytes);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", file, error.what()));
  }
  const auto points = static_cast<int>(raw.p.size());
  return FinishCloud(std::move(raw), 1, points, false, file);
}

RecordedCloud ParseKittiBin(std::string_view bytes, const std::string& file) {
  constexpr size_t kRecordBytes = 16;
  core::ByteReader reader(bytes, file);
  if (bytes.size() % kRecordBytes != 0)
    reader.Fail(fmt::format("{} bytes are not a multiple of {} (x y z intensity, float32)", bytes.size(),
                            kRecordBytes));
  if (bytes.size() / kRecordBytes > 2147483647) reader.Fail("more than 2^31 points");
  RawCloud raw;
  raw.p.resize(bytes.size() / kRecordBytes);
  for (core::Vec3f& p : raw.p) {
    for (int k = 0; k < 3; ++k) p[k] = reader.Next<float>();
    reader.Take(4);
  }
  const auto points = static_cast<int>(raw.p.size());
  return FinishCloud(std::move(raw), 1, points, false, file);
}

}  // namespace atlas::mapping
