#include "experiments/video/run_recording.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <set>

#include "core/errors.h"
#include "core/files.h"
#include "core/named_files.h"
#include "core/safe_text.h"

namespace atlas::experiments {
namespace {

constexpr std::string_view kMagic = "SE-Atlas recording 1\n";

/// Appends a value as it lies in memory (little-endian); counts come before what they count.
template <typename T>
void Put(std::string* out, const T& value) {
  out->append(reinterpret_cast<const char*>(&value), sizeof value);
}

void PutText(std::string* out, const std::string& text) {
  Put(out, static_cast<uint32_t>(text.size()));
  *out += text;
}

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
    std::string text(Take(size), size);
    core::RefuseControlCharacters(text, file_);
    return text;
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

std::vector<Key> KeysOf(const std::vector<core::Vec3f>& centers, double resolution_m) {
  std::vector<Key> keys;
  keys.reserve(centers.size());
  for (const core::Vec3f& p : centers) {
    Key key;
    for (int axis = 0; axis < 3; ++axis) {
      key[static_cast<size_t>(axis)] = static_cast<int16_t>(std::floor(p[axis] / resolution_m));
    }
    keys.push_back(key);
  }
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

void PutKeys(std::string* out, const std::vector<Key>& keys, const std::vector<Key>& except) {
  std::vector<Key> list;
  std::set_difference(keys.begin(), keys.end(), except.begin(), except.end(), std::back_inserter(list));
  Put(out, static_cast<uint32_t>(list.size()));
  for (const Key& key : list) Put(out, key);
}

std::vector<Key> GetKeys(Reader* in) {
  std::vector<Key> keys(in->GetCount(sizeof(Key)));
  for (Key& key : keys) key = in->Get<Key>();
  return keys;
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

RecordingWriter::RecordingWriter(const std::string& scene, const std::string& robot, double resolution_m)
    : header_(kMagic), resolution_m_(resolution_m) {
  PutText(&header_, scene);
  PutText(&header_, robot);
  Put(&header_, resolution_m);
}

void RecordingWriter::AddState(const sim::Snapshot& state) {
  if (state_count_++ == 0) coordinates_ = static_cast<uint32_t>(state.qpos.size());
  assert(state.qpos.size() == coordinates_);
  Put(&states_, state.time_s);
  for (const double q : state.qpos) Put(&states_, static_cast<float>(q));
}

void RecordingWriter::AddMap(double time_s, const std::vector<core::Vec3f>& occupied_map) {
  PutKeyframe(time_s, KeysOf(occupied_map, resolution_m_), {}, std::nullopt);
}

void RecordingWriter::AddPlan(double time_s, const std::vector<core::Vec2>& path_map,
                              const std::optional<ChosenView>& view) {
  PutKeyframe(time_s, keys_, path_map, view);
}

void RecordingWriter::PutKeyframe(double time_s, std::vector<Key> keys,
                                  const std::vector<core::Vec2>& path_map,
                                  const std::optional<ChosenView>& view) {
  ++keyframe_count_;
  Put(&keyframes_, time_s);
  PutKeys(&keyframes_, keys, keys_);  // appeared
  PutKeys(&keyframes_, keys_, keys);  // vanished
  keys_ = std::move(keys);
  Put(&keyframes_, static_cast<uint32_t>(path_map.size()));
  for (const core::Vec2& p : path_map) {
    Put(&keyframes_, p.x());
    Put(&keyframes_, p.y());
  }
  Put(&keyframes_, static_cast<uint8_t>(view.has_value()));
  if (!view) return;
  Put(&keyframes_, view->p_map.x());
  Put(&keyframes_, view->p_map.y());
  Put(&keyframes_, view->yaw_rad);
}

void RecordingWriter::Save(const std::filesystem::path& path) const {
  std::string bytes = header_;
  bytes.reserve(header_.size() + states_.size() + keyframes_.size() + 3 * sizeof(uint32_t));
  Put(&bytes, coordinates_);
  Put(&bytes, state_count_);
  bytes += states_;
  Put(&bytes, keyframe_count_);
  bytes += keyframes_;
  core::WriteFileAtomically(path, bytes);
}

void SaveRecording(const std::filesystem::path& path, const RunRecording& recording) {
  RecordingWriter writer(recording.scene, recording.robot, recording.resolution_m);
  for (const sim::Snapshot& state : recording.states) writer.AddState(state);
  for (const VideoKeyframe& keyframe : recording.keyframes) {
    writer.PutKeyframe(keyframe.time_s, KeysOf(keyframe.occupied_map, recording.resolution_m),
                       keyframe.path_map, keyframe.view);
  }
  writer.Save(path);
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
  for (std::string* name : {&recording.scene, &recording.robot}) {
    const std::filesystem::path kept = path.parent_path() / *name;
    std::error_code error;
    if (core::IsFileName(*name) && std::filesystem::is_regular_file(kept, error)) *name = kept.string();
  }
  return recording;
}

}  // namespace atlas::experiments
