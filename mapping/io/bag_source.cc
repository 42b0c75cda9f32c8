#include "mapping/io/bag_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <set>

#include "core/errors.h"
#include "mapping/io/bag_file.h"
#include "mapping/io/bag_messages.h"
#include "mapping/io/bag_transforms.h"

namespace atlas::mapping {
namespace {

namespace fs = std::filesystem;
using core::InputError;
using core::Pose;
using Connections = std::vector<BagConnection>;
using OfType = std::function<bool(std::string_view)>;

std::vector<std::string> TopicsOf(const Connections& connections, const OfType& wanted) {
  std::set<std::string> topics;
  for (const BagConnection& c : connections) {
    if (wanted(c.type)) topics.insert(c.topic);
  }
  return {topics.begin(), topics.end()};
}

std::string List(const std::vector<std::string>& names) {
  constexpr size_t kMost = 12;
  std::string text;
  for (size_t i = 0; i < std::min(kMost, names.size()); ++i) text += (i > 0 ? ", " : "") + names[i];
  if (names.size() > kMost) text += ", ...";
  return names.empty() ? "none" : text;
}

/// The topic asked for, or the only one that serves.
std::string ChooseTopic(const std::string& file, const Connections& connections, const std::string& asked,
                        const OfType& serves, const std::string& what) {
  const std::vector<std::string> topics = TopicsOf(connections, serves);
  if (asked.empty()) {
    if (topics.size() == 1) return topics[0];
    if (topics.empty()) {
      const auto all = TopicsOf(connections, [](std::string_view) { return true; });
      throw InputError(fmt::format("{}: no topic with {} (topics: {})", file, what, List(all)));
    }
    throw InputError(fmt::format("{}: {} topics with {}; name one as {}:{} (topics: {})", file, topics.size(),
                                 what, file, topics[0], List(topics)));
  }
  for (const BagConnection& c : connections) {
    if (c.topic != asked && c.topic != "/" + asked) continue;
    if (serves(c.type)) return c.topic;
    throw InputError(fmt::format("{}: topic {} holds {}, not {}", file, c.topic, c.type, what));
  }
  throw InputError(fmt::format("{}: {}", file, core::UnknownName("topic", asked, topics)));
}

std::vector<uint32_t> ConnectionsOf(const Connections& connections, const std::string& topic) {
  std::vector<uint32_t> ids;
  for (const BagConnection& c : connections) {
    if (c.topic == topic) ids.push_back(c.id);
  }
  return ids;
}

std::string NameOf(const std::string& topic, size_t index) {
  return fmt::format("{}[{}]", topic, index);
}

class BagSource : public ScanSource {
 public:
  BagSource(const fs::path& path, const std::string& asked) : bag_(path), file_(path.string()) {
    const std::string topic = ChooseTopic(
        file_, bag_.connections(), asked, [](std::string_view type) { return type == kCloudType; },
        std::string(kCloudType));
    std::vector<std::pair<double, BagMessage>> found;
    for (const BagMessage& m : bag_.MessagesOf(ConnectionsOf(bag_.connections(), topic))) {
      const BagHeader header = ParseBagHeader(bag_.Read(m, kBagHeaderBytes), file_ + ": " + topic);
      found.emplace_back(header.stamp_s > 0.0 ? header.stamp_s : m.time_s, m);
      if (found.size() == 1) frame_ = header.frame;
    }
    if (found.empty()) throw InputError(fmt::format("{}: topic {} has no messages", file_, topic));
    std::stable_sort(found.begin(), found.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& [stamp, message] : found) {
      entries_.push_back({NameOf(topic, messages_.size()), stamp, {}});
      messages_.push_back(message);
    }
    description_ = fmt::format("{}:{}", file_, topic);
  }

  RecordedCloud Read(size_t index) const override {
    return ParseCloudMessage(bag_.Read(messages_[index]), file_ + ": " + entries_[index].name);
  }

 private:
  BagFile bag_;
  std::string file_;
  std::vector<BagMessage> messages_;
};

/// The poses of all messages, or of the longest path.
std::vector<BagPose> PosesOf(const BagFile& bag, const std::string& file, const std::string& topic) {
  std::vector<BagPose> all;
  for (const BagConnection& c : bag.connections()) {
    if (c.topic != topic) continue;
    size_t i = 0;
    for (const BagMessage& m : bag.MessagesOf({c.id})) {
      auto poses = ParsePoseMessage(c.type, bag.Read(m), file + ": " + NameOf(topic, i++));
      if (c.type == "nav_msgs/Path") {
        if (poses.size() > all.size()) all = std::move(poses);
        continue;
      }
      if (poses[0].stamp_s == 0.0) poses[0].stamp_s = m.time_s;
      all.push_back(std::move(poses[0]));
    }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const BagPose& a, const BagPose& b) { return a.stamp_s < b.stamp_s; });
  return all;
}

/// Topics of transforms serve where one is named; the static ones are no motion.
bool HoldsPoses(const std::string& asked, std::string_view type) {
  return IsPoseType(type) || (!asked.empty() && IsTransformsType(type));
}

}  // namespace

std::pair<std::string, std::string> SplitTopic(const std::string& text) {
  const size_t at = text.find(".bag:");
  if (at == std::string::npos) return {text, ""};
  return {text.substr(0, at + 4), text.substr(at + 5)};
}

bool NamesBag(const std::string& text) {
  return SplitTopic(text).first.ends_with(".bag");
}

std::unique_ptr<ScanSource> OpenBag(const fs::path& file, const std::string& topic) {
  return std::make_unique<BagSource>(file, topic);
}

RecordedPoses ReadBagPoses(const fs::path& path, const std::string& asked, const std::string& lidar_frame) {
  const BagFile bag(path);
  const std::string file = path.string();
  const std::string topic = ChooseTopic(
      file, bag.connections(), asked, [&](std::string_view type) { return HoldsPoses(asked, type); },
      "poses");
  const std::string lidar = FrameName(lidar_frame);
  for (const BagConnection& c : bag.connections()) {
    if (c.topic != topic || !IsTransformsType(c.type)) continue;
    if (lidar.empty())
      throw InputError(fmt::format("{}: transforms give the poses of a bag's clouds, without --calib", file));
    return BagTransforms(bag, file, topic).OfFrame(lidar);
  }
  const std::vector<BagPose> found = PosesOf(bag, file, topic);
  if (found.empty()) throw InputError(fmt::format("{}: topic {} has no messages", file, topic));
  const std::string posed = FrameName(found[0].child_frame);
  RecordedPoses poses;
  Pose T_posed_lidar = Pose::Identity();
  if (!posed.empty() && !lidar.empty() && posed != lidar) {
    const auto T = BagTransforms(bag, file).Static(posed, lidar);
    if (T) T_posed_lidar = *T;
    poses.note = T ? fmt::format("from {} to {} by /tf_static", posed, lidar)
                   : fmt::format("of {}, taken for {}'s: give --calib where they differ", posed, lidar);
  }
  for (const BagPose& pose : found) {
    poses.time_s.push_back(pose.stamp_s);
    poses.T_map_lidar.push_back(pose.pose * T_posed_lidar);
  }
  return poses;
}

std::vector<std::string> PoseTopicsOf(const fs::path& file) {
  return TopicsOf(BagFile(file).connections(), IsPoseType);
}

}  // namespace atlas::mapping
