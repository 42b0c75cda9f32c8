#include "mapping/io/scan_source.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <fstream>
#include <set>

#include "core/errors.h"
#include "core/files.h"
#include "core/safe_text.h"
#include "core/text_lines.h"
#include "mapping/io/bag_source.h"
#include "mapping/io/scan_graph.h"

namespace atlas::mapping {
namespace {

namespace fs = std::filesystem;
using core::InputError;

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

/// The run of digits that ends `text`.
std::string_view TrailingDigits(std::string_view text) {
  size_t begin = text.size();
  while (begin > 0 && IsDigit(text[begin - 1])) --begin;
  return text.substr(begin);
}

class FileSource : public ScanSource {
 public:
  explicit FileSource(std::vector<fs::path> files) : files_(std::move(files)) {
    const auto name = [](const fs::path& p) { return p.filename().string(); };
    std::sort(files_.begin(), files_.end(),
              [&](const auto& a, const auto& b) { return NaturalLess(name(a), name(b)); });
    for (const fs::path& file : files_)
      entries_.push_back({name(file), TimeInName(file.stem().string()), {}});
    description_ = files_.size() == 1
                       ? files_[0].string()
                       : fmt::format("{} clouds of {}", files_.size(), files_[0].parent_path().string());
    SetPoses();
  }

  RecordedCloud Read(size_t index) const override { return ReadCloud(files_[index]); }

 private:
  /// By relations between files, else by viewpoints where any says more than identity.
  void SetPoses() {
    std::vector<std::string> stems;
    for (const fs::path& file : files_) stems.push_back(file.stem().string());
    const fs::path folder = files_[0].parent_path();
    std::vector<core::Pose> poses;
    if (files_.size() > 1) poses = PosesFromRelations(folder.empty() ? "." : folder, stems);
    pose_origin_ = "files T_A_B.txt";
    if (poses.empty() && files_[0].extension() == ".pcd") {
      pose_origin_ = "viewpoints";
      for (const fs::path& file : files_) poses.push_back(ViewpointOf(file));
      const auto is_identity = [](const core::Pose& T) { return T.matrix().isIdentity(0.0); };
      if (std::all_of(poses.begin(), poses.end(), is_identity)) poses.clear();
    }
    for (size_t i = 0; i < poses.size(); ++i) entries_[i].T_map_lidar = poses[i];
  }

  std::vector<fs::path> files_;
};

class GraphSource : public ScanSource {
 public:
  explicit GraphSource(const fs::path& path) : file_(path.string()), bytes_(core::ReadFile(path)) {
    index_ = IndexScanGraph(bytes_, file_);
    for (size_t i = 0; i < index_.nodes.size(); ++i) {
      entries_.push_back(
          {fmt::format("{}[{}]", path.filename().string(), i), {}, index_.nodes[i].T_map_lidar});
    }
    description_ = file_;
    pose_origin_ = "the graph";
  }

  RecordedCloud Read(size_t index) const override { return ReadScanOfGraph(bytes_, index_, index, file_); }

 private:
  std::string file_, bytes_;
  ScanGraphIndex index_;
};

std::string Lowercase(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// The clouds of `folder` whose names match `pattern`; all of one kind.
std::vector<fs::path> CloudsOf(const fs::path& folder, const std::string& pattern) {
  std::error_code error;
  std::vector<fs::path> files;
  std::set<std::string> kinds;
  for (auto it = fs::directory_iterator(folder.empty() ? "." : folder, error);
       !error && it != fs::directory_iterator(); it.increment(error)) {
    const fs::path file = it->path();
    if (!HasCloudExtension(file) || !it->is_regular_file(error)) continue;
    if (::fnmatch(pattern.c_str(), file.filename().c_str(), 0) != 0) continue;
    core::RefuseControlCharacters(file.filename().string(), folder.string() + ": the name of a cloud");
    files.push_back(folder / file.filename());
    kinds.insert(Lowercase(file.extension().string()));
  }
  if (error) throw InputError(fmt::format("{}: {}", folder.string(), error.message()));
  if (files.empty())
    throw InputError(
        fmt::format("{}: holds no clouds (.pcd, .ply, .bin) named {}", folder.string(), pattern));
  if (kinds.size() > 1) {
    throw InputError(fmt::format("{}: holds clouds of several kinds; name one, such as {}/*{}",
                                 folder.string(), folder.string(), *kinds.begin()));
  }
  return files;
}

}  // namespace

std::optional<double> TimeInName(std::string_view stem) {
  const std::string_view last = TrailingDigits(stem);
  if (last.empty()) return std::nullopt;
  const std::string_view before = stem.substr(0, stem.size() - last.size());
  if (before.ends_with('.') || before.ends_with('_')) {
    const std::string_view first = TrailingDigits(before.substr(0, before.size() - 1));
    const auto whole = core::ParseNumber<double>(first);
    if (before.ends_with('.') && whole && first.size() <= 12)
      return core::ParseNumber<double>(stem.substr(before.size() - 1 - first.size()));
    const auto nanoseconds = core::ParseNumber<double>(last);
    if (whole && first.size() >= 9 && first.size() <= 12 && last.size() <= 9)
      return *whole + 1e-9 * *nanoseconds;
  }
  const auto number = core::ParseNumber<uint64_t>(last);
  if (!number) return std::nullopt;
  const auto value = static_cast<double>(*number);
  switch (last.size()) {
    case 10:
      return value;
    case 13:
      return value * 1e-3;
    case 16:
      return value * 1e-6;
    case 19:
      return static_cast<double>(*number / 1000000000) + 1e-9 * static_cast<double>(*number % 1000000000);
    default:
      return std::nullopt;
  }
}

bool NaturalLess(std::string_view a, std::string_view b) {
  size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (!IsDigit(a[i]) || !IsDigit(b[j])) {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
      continue;
    }
    const auto run = [](std::string_view text, size_t& at) {
      while (at < text.size() && text[at] == '0') ++at;
      const size_t begin = at;
      while (at < text.size() && IsDigit(text[at])) ++at;
      return text.substr(begin, at - begin);
    };
    const std::string_view x = run(a, i), y = run(b, j);
    if (x.size() != y.size()) return x.size() < y.size();
    if (x != y) return x < y;
  }
  if ((i < a.size()) != (j < b.size())) return j < b.size();
  return a < b;  // equal but for leading zeros
}

std::unique_ptr<ScanSource> OpenScans(const std::string& scans) {
  const auto [path, topic] = SplitTopic(scans);
  const fs::path file = path;
  const std::string ending = Lowercase(file.extension().string());
  std::error_code error;
  if (fs::is_directory(file, error)) return std::make_unique<FileSource>(CloudsOf(file, "*"));
  if (!fs::exists(file, error) && file.filename().string().find_first_of("*?[") != std::string::npos)
    return std::make_unique<FileSource>(CloudsOf(file.parent_path(), file.filename().string()));
  if (!fs::exists(file, error)) throw InputError(fmt::format("{}: no such file or folder", path));
  if (ending == ".bag") return OpenBag(file, topic);
  if (ending == ".graph" || ending == ".log" || ending == ".txt") return std::make_unique<GraphSource>(file);
  if (HasCloudExtension(file)) return std::make_unique<FileSource>(std::vector<fs::path>{file});
  throw InputError(
      fmt::format("{}: '{}' is no log read here (a folder, .pcd, .ply, .bin, .graph, .bag)", path, ending));
}

}  // namespace atlas::mapping
