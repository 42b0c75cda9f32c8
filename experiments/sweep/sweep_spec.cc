#include "experiments/sweep/sweep_spec.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <set>

#include "core/errors.h"
#include "core/files.h"
#include "core/named_files.h"
#include "core/safe_text.h"
#include "core/yaml_text.h"
#include "experiments/identity/experiment_config.h"

namespace atlas::experiments {
namespace fs = std::filesystem;
namespace {

using core::InputError;

constexpr const char* kSweepFolder = "experiments/configs/sweeps";
constexpr size_t kMostRuns = 100000;

/// The YAML of one file; every complaint names file, line and field.
class SweepFile {
 public:
  explicit SweepFile(const fs::path& path) : path_(path.string()) {
    root_ = core::LoadYaml(path);
    if (!root_.IsMap()) throw InputError(path_ + ": expected keys such as 'experiments' and 'seeds'");
    const std::vector<std::string> known = {"doc",      "experiments", "grid",       "seeds",
                                            "variants", "set",         "estimate_s", "limit_s"};
    for (const auto& entry : root_) {
      const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "";
      if (std::count(known.begin(), known.end(), key) == 0)
        Fail(entry.first, core::UnknownName("key", key, known));
    }
  }

  YAML::Node At(const char* key) const { return root_[key]; }
  bool Has(const char* key) const { return static_cast<bool>(root_[key]); }

  std::string Text(const YAML::Node& node, const std::string& field) const {
    if (!node.IsScalar() || node.Scalar().empty()) Fail(node, field + ": expected text");
    core::RefuseControlCharacters(node.Scalar(), Place(node, field));
    return node.Scalar();
  }
  /// Text that may go over several lines of the file.
  std::string Prose(const YAML::Node& node, const std::string& field) const {
    if (!node.IsScalar()) Fail(node, field + ": expected text");
    std::string text = node.Scalar();
    std::replace(text.begin(), text.end(), '\n', ' ');
    return core::Printable(text);
  }
  std::vector<std::string> TextList(const YAML::Node& node, const std::string& field) const {
    std::vector<std::string> list;
    if (node.IsScalar()) {
      list.push_back(Text(node, field));
    } else if (node.IsSequence()) {
      for (const auto& item : node) list.push_back(Text(item, field));
    } else {
      Fail(node, field + ": expected a list");
    }
    if (list.empty()) Fail(node, field + ": the list is empty");
    if (std::set<std::string>(list.begin(), list.end()).size() != list.size())
      Fail(node, field + ": a value stands twice");
    return list;
  }
  template <typename T>
  T Number(const YAML::Node& node, const std::string& field, T min, T max) const {
    T value{};
    if (!node.IsScalar() || !YAML::convert<T>::decode(node, value) || !(value >= min && value <= max)) {
      const std::string found = node.IsScalar() ? node.Scalar() : "something else";
      Fail(node, fmt::format("{}: expected a number from {} to {}, found '{}'", field, min, max, found));
    }
    return value;
  }
  std::string Place(const YAML::Node& node, const std::string& field) const {
    return fmt::format("{}:{}: {}", path_, node.Mark().line + 1, field);
  }
  [[noreturn]] void Fail(const YAML::Node& node, const std::string& what) const {
    throw InputError(Place(node, what));
  }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  YAML::Node root_;
};

std::vector<uint64_t> ReadSeeds(const SweepFile& file) {
  constexpr uint64_t kMostSeeds = 10000;
  const YAML::Node node = file.At("seeds");
  std::vector<uint64_t> seeds;
  if (node.IsSequence()) {
    for (const auto& item : node) seeds.push_back(file.Number<uint64_t>(item, "seeds", 0, kGreatestSeed));
    if (seeds.empty()) file.Fail(node, "seeds: the list is empty");
    if (std::set<uint64_t>(seeds.begin(), seeds.end()).size() != seeds.size())
      file.Fail(node, "seeds: a seed stands twice");
    return seeds;
  }
  const uint64_t count = file.Number<uint64_t>(node, "seeds", 1, kMostSeeds);
  for (uint64_t seed = 1; seed <= count; ++seed) seeds.push_back(seed);
  return seeds;
}

void RefuseSeed(const SweepFile& file, const YAML::Node& node, const std::string& field,
                const std::string& key) {
  if (key == "seed") file.Fail(node, field + ": seeds of a sweep stand under 'seeds'");
}

/// A list of "a.b=value", their places added to the sweep's.
std::vector<std::string> ReadAssignments(const SweepFile& file, const YAML::Node& node,
                                         const std::string& field, SweepSpec* spec) {
  const fs::path beside = fs::path(file.path()).parent_path();
  std::vector<std::string> list = file.TextList(node, field);
  for (std::string& text : list) {
    const size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
      file.Fail(node, fmt::format("{}: expected a.b=value, found '{}'", field, text));
    RefuseSeed(file, node, field, text.substr(0, equals));
    text = text.substr(0, equals + 1) + core::FileBeside(beside, text.substr(equals + 1));
    spec->places[text] = file.Place(node, field);
  }
  return list;
}

void ReadGrid(const SweepFile& file, SweepSpec* spec) {
  const fs::path beside = fs::path(file.path()).parent_path();
  if (!file.At("grid").IsMap()) file.Fail(file.At("grid"), "grid: expected parameter: [values]");
  for (const auto& entry : file.At("grid")) {
    const std::string key = file.Text(entry.first, "grid");
    RefuseSeed(file, entry.first, "grid", key);
    spec->grid.emplace_back(key, file.TextList(entry.second, "grid." + key));
    for (std::string& value : spec->grid.back().second) {
      value = core::FileBeside(beside, value);
      spec->places[key + "=" + value] = file.Place(entry.first, "grid");
    }
  }
}

void ReadVariants(const SweepFile& file, SweepSpec* spec) {
  if (!file.At("variants").IsMap())
    file.Fail(file.At("variants"), "variants: expected name: [a.b=value, ...]");
  for (const auto& entry : file.At("variants")) {
    const std::string name = file.Text(entry.first, "variants");
    spec->variants.emplace_back(name, ReadAssignments(file, entry.second, "variants." + name, spec));
  }
}

fs::path FileOf(const std::string& name_or_path) {
  const bool is_path = name_or_path.ends_with(".yaml") || name_or_path.ends_with(".yml") ||
                       name_or_path.find('/') != std::string::npos;
  if (is_path) return name_or_path;
  const std::vector<std::string> names = SweepNames();
  if (std::count(names.begin(), names.end(), name_or_path) == 0) {
    throw InputError(core::UnknownName("sweep", name_or_path, names));
  }
  return core::InstalledFile(fs::path(kSweepFolder) / (name_or_path + ".yaml"));
}

/// A value as part of a folder's name; a file's is its stem.
std::string FolderWord(const std::string& value) {
  const bool is_file = fs::path(value).has_extension() && value.find('/') != std::string::npos;
  return core::FileNameFrom(is_file ? fs::path(value).stem().string() : value);
}

}  // namespace

std::vector<std::string> SweepNames() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(core::InstalledFile(kSweepFolder))) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

SweepSpec LoadSweep(const std::string& name_or_path) {
  const fs::path path = FileOf(name_or_path);
  const SweepFile file(path);
  SweepSpec spec;
  spec.name = path.stem().string();
  spec.file = file.path();
  for (const char* key : {"experiments", "seeds"}) {
    if (!file.Has(key)) throw InputError(fmt::format("{}: '{}' is missing", file.path(), key));
  }
  const fs::path beside = path.parent_path();
  if (file.Has("doc")) spec.doc = file.Prose(file.At("doc"), "doc");
  spec.experiments = file.TextList(file.At("experiments"), "experiments");
  for (std::string& experiment : spec.experiments) experiment = core::FileBeside(beside, experiment);
  spec.seeds = ReadSeeds(file);
  if (file.Has("set")) spec.set = ReadAssignments(file, file.At("set"), "set", &spec);
  if (file.Has("estimate_s"))
    spec.estimate_s = file.Number<double>(file.At("estimate_s"), "estimate_s", 0.1, 1e6);
  if (file.Has("limit_s")) spec.limit_s = file.Number<double>(file.At("limit_s"), "limit_s", 0.1, 1e7);
  if (file.Has("grid")) ReadGrid(file, &spec);
  if (file.Has("variants")) ReadVariants(file, &spec);
  return spec;
}

double LimitOf(const SweepSpec& spec) {
  constexpr double kHourS = 3600.0, kTimesEstimate = 10.0;
  return spec.limit_s > 0.0 ? spec.limit_s : std::max(kHourS, kTimesEstimate * spec.estimate_s);
}

std::vector<SweepRun> ExpandSweep(const SweepSpec& spec, const fs::path& out) {
  size_t combinations = 1;
  for (const auto& [key, values] : spec.grid) combinations *= values.size();
  const size_t variants = std::max<size_t>(1, spec.variants.size());
  combinations *= variants;
  if (combinations * spec.experiments.size() * spec.seeds.size() > kMostRuns) {
    throw InputError(fmt::format("sweep {}: more than {} runs", spec.name, kMostRuns));
  }
  std::vector<SweepRun> runs;
  std::set<fs::path> folders;
  for (const std::string& experiment : spec.experiments) {
    for (size_t combination = 0; combination < combinations; ++combination) {
      SweepRun run{
          .experiment = experiment, .assignments = spec.set, .seed = 0, .identity = nullptr, .folder = {}};
      std::string folder = FolderWord(experiment);
      size_t block = combinations;
      for (const auto& [key, values] : spec.grid) {
        block /= values.size();
        const std::string& value = values[combination / block % values.size()];
        run.assignments.push_back(key + "=" + value);
        folder.append("_").append(FolderWord(value));
      }
      if (!spec.variants.empty()) {
        const auto& [name, assignments] = spec.variants[combination % variants];
        run.assignments.insert(run.assignments.end(), assignments.begin(), assignments.end());
        folder.append("_").append(FolderWord(name));
      }
      for (const uint64_t seed : spec.seeds) {
        run.seed = seed;
        run.folder = out / folder / std::to_string(seed);
        if (!folders.insert(run.folder).second) {
          throw InputError(fmt::format("sweep {}: two runs would share {}", spec.name, run.folder.string()));
        }
        runs.push_back(run);
      }
    }
  }
  return runs;
}

}  // namespace atlas::experiments
