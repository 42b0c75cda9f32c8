#include "experiments/video/run_recording.h"

#include <array>
#include <cstring>
#include <set>

#include "core/errors.h"
#include "core/files.h"

namespace atlas::experiments {
namespace {

constexpr std::string_view kMagic = "SE-Atlas recording 1\n";

/// Little-endian values one after the other; counts come before what they count.
class Writer {
 public:
  template <typename T>
  void Put(const T& value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void Put(const std::string& text) {
    Put(static_cast<uint32_t>(text.size()));
    bytes_ += text;
  }
  void PutRaw(std::string_view text) { bytes_ += text; }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

class Reader {
 public:
  Reader(std::string bytes, std::string file) : bytes_(std::move(bytes)), file_(std::move(file)) {}

  template <typename T>
  T Get() {
    T value;
    std::memcpy(&value, Take(sizeof(T)), sizeof(T));
    return value;
  }
  std::string GetText() {
    const auto size = Get<uint32_t>();
    return {Take(size), size};
  }
  /// A count of items of `item_bytes`, which must still be there.
  size_t GetCount(size_t item_bytes) {
    const auto count = Get<uint32_t>();
    if (count > (bytes_.size() - at_) / item_bytes) Fail();
    return count;
  }
  const char* Take(size_t size) {
    if (size > bytes_.size() - at_) Fail();
    at_ += size;
    return bytes_.data() + at_ - size;
  }
  [[noreturn]] void Fail() const { throw core::InputError(file_ + ": not a whole SE-Atlas recording"); }

 private:
  std::string bytes_, file_;
  size_t at_ = 0;
};

using Key = std::array<int16_t, 3>;

std::set<Key> KeysOf(const std::vector<core::Vec3f>& centers, double resolution_m) {
  std::set<Key> keys;
  for (const core::Vec3f& p : centers) {
    Key key;
    for (int axis = 0; axis < 3; ++axis) {
      key[static_cast<size_t>(axis)] = static_cast<int16_t>(std::floor(p[axis] / resolution_m));
    }
    keys.insert(key);
  }
  return keys;
}

void PutKeys(Writer* out, const std::set<Key>& keys, const std::set<Key>& except) {
  std::vector<Key> list;
  std::set_difference(keys.begin(), keys.end(), except.begin(), except.end(), std::back_inserter(list));
  out->Put(static_cast<uint32_t>(list.size()));
  for (const Key& key : list) out->Put(key);
}

std::vector<Key> GetKeys(Reader* in) {
  std::vector<Key> keys(in->GetCount(sizeof(Key)));
  for (Key& key : keys) key = in->Get<Key>();
  return keys;
}

void PutView(Writer* out, const VideoKeyframe& keyframe) {
  out->Put(static_cast<uint32_t>(keyframe.path_map.size()));
  for (const core::Vec2& p : keyframe.path_map) {
    out->Put(p.x());
    out->Put(p.y());
  }
  out->Put(static_cast<uint8_t>(keyframe.view.has_value()));
  if (!keyframe.view) return;
  out->Put(keyframe.view->p_map.x());
  out->Put(keyframe.view->p_map.y());
  out->Put(keyframe.view->yaw_rad);
}

void GetView(Reader* in, VideoKeyframe* keyframe) {
  keyframe->path_map.resize(in->GetCount(2 * sizeof(double)));
  for (core::Vec2& p : keyframe->path_map) {
    p.x() = in->Get<double>();
    p.y() = in->Get<double>();
  }
  if (in->Get<uint8_t>() == 0) return;
  ChosenView view;
  view.p_map.x() = in->Get<double>();
  view.p_map.y() = in->Get<double>();
  view.yaw_rad = in->Get<double>();
  keyframe->view = view;
}

}  // namespace

void SaveRecording(const std::filesystem::path& path, const RunRecording& recording) {
  Writer out;
  out.PutRaw(kMagic);
  out.Put(recording.scene);
  out.Put(recording.robot);
  out.Put(recording.resolution_m);
  const size_t coordinates = recording.states.empty() ? 0 : recording.states.front().qpos.size();
  out.Put(static_cast<uint32_t>(coordinates));
  out.Put(static_cast<uint32_t>(recording.states.size()));
  for (const sim::Snapshot& state : recording.states) {
    out.Put(state.time_s);
    for (size_t i = 0; i < coordinates; ++i) out.Put(static_cast<float>(state.qpos.at(i)));
  }
  out.Put(static_cast<uint32_t>(recording.keyframes.size()));
  std::set<Key> before;
  for (const VideoKeyframe& keyframe : recording.keyframes) {
    std::set<Key> keys = KeysOf(keyframe.occupied_map, recording.resolution_m);
    out.Put(keyframe.time_s);
    PutKeys(&out, keys, before);  // appeared
    PutKeys(&out, before, keys);  // vanished
    PutView(&out, keyframe);
    before = std::move(keys);
  }
  core::WriteFileAtomically(path, out.bytes());
}

RunRecording LoadRecording(const std::filesystem::path& path) {
  Reader in(core::ReadFile(path), path.string());
  if (std::string_view(in.Take(kMagic.size()), kMagic.size()) != kMagic) in.Fail();
  RunRecording recording;
  recording.scene = in.GetText();
  recording.robot = in.GetText();
  recording.resolution_m = in.Get<double>();
  const size_t coordinates = in.GetCount(1);
  recording.states.resize(in.GetCount(sizeof(double) + coordinates * sizeof(float)));
  for (sim::Snapshot& state : recording.states) {
    state.time_s = in.Get<double>();
    state.qpos.resize(coordinates);
    for (double& q : state.qpos) q = in.Get<float>();
  }
  recording.keyframes.resize(in.GetCount(sizeof(double)));
  std::set<Key> keys;
  for (VideoKeyframe& keyframe : recording.keyframes) {
    keyframe.time_s = in.Get<double>();
    for (const Key& key : GetKeys(&in)) keys.insert(key);
    for (const Key& key : GetKeys(&in)) keys.erase(key);
    for (const Key& key : keys) {
      const core::Vec3 cell(key[0], key[1], key[2]);
      keyframe.occupied_map.push_back(((cell.array() + 0.5) * recording.resolution_m).matrix().cast<float>());
    }
    GetView(&in, &keyframe);
  }
  return recording;
}

}  // namespace atlas::experiments
