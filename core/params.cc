#include "core/params.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include <charconv>
#include <functional>
#include <set>

#include "core/errors.h"
#include "core/named_files.h"
#include "core/param_entry.h"
#include "core/safe_text.h"
#include "core/yaml_text.h"

namespace atlas::core {
namespace fs = std::filesystem;
namespace {

using Entry = ParamEntry;

/// Files of one chain of `extends`.
constexpr size_t kMostExtended = 16;

std::string RangeText(const ParamInfo& info) {
  if (!info.choices.empty()) return fmt::format("{}", fmt::join(info.choices, " | "));
  const bool low = std::isfinite(info.min), high = std::isfinite(info.max);
  if (low && high) return fmt::format("[{}, {}]", info.min, info.max);
  if (low) return fmt::format(">= {}", info.min);
  if (high) return fmt::format("<= {}", info.max);
  return "";
}

/// Reads fields out of the merged tree, remembers which keys were known, and collects the rows.
class LoadVisitor : public ParamVisitor {
 public:
  explicit LoadVisitor(const Entry& root) { stack_.push_back({&root, "", {}}); }

  std::vector<ParamRow> TakeRows() {
    CheckUnknown();
    return std::move(rows_);
  }

  void Field(const std::string& name, double* value, const ParamInfo& info) override {
    ReadNumber(name, value, info, "a number");
  }
  void Field(const std::string& name, int* value, const ParamInfo& info) override {
    ReadNumber(name, value, info, "a whole number");
  }
  void Field(const std::string& name, bool* value, const ParamInfo& info) override {
    if (const Entry* entry = Scalar(name, "true or false")) {
      if (!YAML::convert<bool>::decode(YAML::Node(entry->scalar), *value))
        WrongType(*entry, name, "true or false");
    }
    AddRow(name, *value ? "true" : "false", info);
  }
  void Field(const std::string& name, std::string* value, const ParamInfo& info) override {
    if (const Entry* entry = Scalar(name, "a name")) {
      *value = CheckedChoice(*entry, name, entry->scalar, info);
      if (info.is_file) *value = FileBeside(entry->folder, *value);
    }
    AddRow(name, *value, info);
  }
  void Field(const std::string& name, std::vector<std::string>* value, const ParamInfo& info) override {
    if (const Entry* entry = Find(name)) {
      if (entry->kind == Entry::Kind::kMap) WrongType(*entry, name, "a list");
      *value =
          entry->kind == Entry::Kind::kSequence ? entry->sequence : std::vector<std::string>{entry->scalar};
      if (value->size() == 1 && value->front().empty()) value->clear();
      for (const std::string& item : *value) CheckedChoice(*entry, name, item, info);
    }
    AddRow(name, fmt::format("[{}]", fmt::join(*value, ", ")), info);
  }
  void Absent(const std::string& name, const std::string& here) override {
    if (const Entry* entry = Find(name)) {
      throw InputError(fmt::format("{}: {}: no parameter of {}", entry->origin, Path(name), here));
    }
  }

 protected:
  void Enter(const std::string& name) override {
    const Entry* entry = Find(name);
    static const Entry kEmpty;
    if (entry == nullptr) {
      entry = &kEmpty;
    } else if (entry->kind == Entry::Kind::kScalar) {
      if (entry->scalar.empty() && !entry->is_null) WrongType(*entry, name, "a name or keys");
      Entry named;  // shorthand: `planner: thesis`
      named.origin = entry->origin;
      if (!entry->scalar.empty()) named.children["name"] = *entry;
      shorthand_.push_back(std::make_unique<Entry>(std::move(named)));
      entry = shorthand_.back().get();
    } else if (entry->kind == Entry::Kind::kSequence) {
      throw InputError(fmt::format("{}: {}: a section, not a list", entry->origin, Path(name)));
    }
    stack_.push_back({entry, Path(name) + ".", {}});
  }
  void Leave() override {
    CheckUnknown();
    stack_.pop_back();
  }

 private:
  struct Level {
    const Entry* entry;
    std::string prefix;
    std::set<std::string> known;
  };

  std::string Path(const std::string& name) const { return stack_.back().prefix + name; }

  const Entry* Find(const std::string& name) {
    Level& level = stack_.back();
    level.known.insert(name);
    const auto found = level.entry->children.find(name);
    return found == level.entry->children.end() ? nullptr : &found->second;
  }

  [[noreturn]] void WrongType(const Entry& entry, const std::string& name, const std::string& wanted) const {
    throw InputError(
        fmt::format("{}: {}: expected {}, got {}", entry.origin, Path(name), wanted, KindText(entry)));
  }

  const Entry* Scalar(const std::string& name, const std::string& wanted) {
    const Entry* entry = Find(name);
    if (entry == nullptr) return nullptr;
    if (entry->kind != Entry::Kind::kScalar) WrongType(*entry, name, wanted);
    return entry;
  }

  template <typename Number>
  void ReadNumber(const std::string& name, Number* value, const ParamInfo& info, const char* wanted) {
    if (const Entry* entry = Scalar(name, wanted)) {
      const std::string& text = entry->scalar;
      Number parsed{};
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), parsed);
      if (error != std::errc{} || end != text.data() + text.size() ||
          !std::isfinite(static_cast<double>(parsed))) {
        WrongType(*entry, name, wanted);
      }
      if (static_cast<double>(parsed) < info.min || static_cast<double>(parsed) > info.max) {
        throw InputError(fmt::format("{}: {}: {} is out of range, must be {}{}", entry->origin, Path(name),
                                     text, RangeText(info), info.unit.empty() ? "" : " " + info.unit));
      }
      *value = parsed;
    }
    AddRow(name, fmt::format("{}", *value), info);
  }

  std::string CheckedChoice(const Entry& entry, const std::string& name, const std::string& value,
                            const ParamInfo& info) const {
    if (!info.choices.empty() &&
        std::find(info.choices.begin(), info.choices.end(), value) == info.choices.end()) {
      throw InputError(fmt::format("{}: {}", entry.origin, UnknownName(Path(name), value, info.choices)));
    }
    return value;
  }

  void AddRow(const std::string& name, std::string value, const ParamInfo& info) {
    const auto found = stack_.back().entry->children.find(name);
    const bool set = found != stack_.back().entry->children.end();
    rows_.push_back({Path(name), std::move(value), info.unit, RangeText(info), info.doc,
                     set ? found->second.origin : "default"});
  }

  void CheckUnknown() const {
    const Level& level = stack_.back();
    for (const auto& [key, child] : level.entry->children) {
      if (level.known.count(key) > 0) continue;
      const std::vector<std::string> valid(level.known.begin(), level.known.end());
      const std::string near = NearestName(key, valid);
      throw InputError(fmt::format("{}: unknown key '{}{}'{}", child.origin, level.prefix, key,
                                   near.empty() ? fmt::format(" (valid: {})", fmt::join(valid, ", "))
                                                : fmt::format("; did you mean '{}{}'?", level.prefix, near)));
    }
  }

  std::vector<Level> stack_;
  std::vector<std::unique_ptr<Entry>> shorthand_;
  std::vector<ParamRow> rows_;
};

}  // namespace

struct ParamSource::Impl {
  Entry root;
  struct OpenFile {
    std::string name;
    fs::path place;
  };
  std::vector<OpenFile> open_files = {};  // the chain of `extends`, to find cycles
};

ParamSource::ParamSource() : impl_(std::make_unique<Impl>()) {}
ParamSource::~ParamSource() = default;
ParamSource::ParamSource(ParamSource&&) noexcept = default;
ParamSource& ParamSource::operator=(ParamSource&&) noexcept = default;

namespace {

/// One name for a file, however its path is spelt.
fs::path PlaceOf(const fs::path& path) {
  std::error_code error;
  const fs::path place = fs::weakly_canonical(path, error);
  return error ? path.lexically_normal() : place;
}

/// The file that `extends` names: beside the one that it stands in, else in `fallback_dir`.
fs::path BaseOf(const Entry& extends, const fs::path& fallback_dir) {
  if (extends.kind != Entry::Kind::kScalar || extends.scalar.empty()) {
    throw InputError(
        fmt::format("{}: extends: expected the name of one file, got {}", extends.origin, KindText(extends)));
  }
  const std::string name = extends.scalar.ends_with(".yaml") ? extends.scalar : extends.scalar + ".yaml";
  std::error_code error;
  const fs::path beside = extends.folder / name;
  if (fs::exists(beside, error)) return beside;
  const fs::path fallback = fallback_dir / name;
  if (fs::exists(fallback, error)) return fallback;
  throw InputError(
      fmt::format("{}: extends '{}', but there is no {}", extends.origin, extends.scalar, fallback.string()));
}

}  // namespace

void ParamSource::MergeFile(const fs::path& path, const fs::path& fallback_dir) {
  const std::string name = path.string();
  const fs::path place = PlaceOf(path);
  std::vector<std::string> chain;
  bool open = false;
  for (const Impl::OpenFile& file : impl_->open_files) {
    chain.push_back(file.name);
    open = open || file.place == place;
  }
  if (open) throw InputError(fmt::format("{}: extends itself through {}", name, fmt::join(chain, " -> ")));
  if (chain.size() >= kMostExtended)
    throw InputError(fmt::format("{}: extends a chain of more than {} files", chain.front(), kMostExtended));
  const YAML::Node yaml = LoadYaml(path);
  if (!yaml.IsMap() && !yaml.IsNull())
    throw InputError(fmt::format("{}:1: expected sections, such as 'scene: car'", name));
  Entry entry = EntryFromYaml(yaml, name, path.parent_path());
  if (const auto extends = entry.children.find("extends"); extends != entry.children.end()) {
    const fs::path base = BaseOf(extends->second, fallback_dir);
    entry.children.erase(extends);
    impl_->open_files.push_back({name, place});
    MergeFile(base, fallback_dir);
    impl_->open_files.pop_back();
  }
  MergeEntry(&impl_->root, std::move(entry));
}

void ParamSource::MergeAssignment(const std::string& assignment) {
  RefuseControlCharacters(assignment, "--set");
  const size_t equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw InputError(fmt::format("--set {}: expected section.key=value", assignment));
  }
  if (static_cast<size_t>(
          std::count(assignment.begin(), assignment.begin() + static_cast<std::ptrdiff_t>(equals), '.')) >=
      kMostYamlDepth)
    throw InputError(fmt::format("--set {}: nested deeper than {} levels", assignment, kMostYamlDepth));
  Entry entry = EntryFromYaml(ParseYaml(assignment.substr(equals + 1), "--set " + assignment), "--set", {});
  if (entry.is_null) throw InputError(fmt::format("--set {}: the value is empty", assignment));
  std::function<void(Entry*)> mark = [&](Entry* e) {
    e->origin = "--set " + assignment;
    for (auto& [key, child] : e->children) mark(&child);
  };
  mark(&entry);
  std::string path = assignment.substr(0, equals);
  while (true) {
    const size_t dot = path.rfind('.');
    const std::string key = dot == std::string::npos ? path : path.substr(dot + 1);
    Entry parent;
    parent.origin = entry.origin;
    parent.children[key] = std::move(entry);
    entry = std::move(parent);
    if (dot == std::string::npos) break;
    path.resize(dot);
  }
  MergeEntry(&impl_->root, std::move(entry));
}

std::optional<std::string> ParamSource::TextAt(const std::string& section, const std::string& key) const {
  const auto found = impl_->root.children.find(section);
  if (found == impl_->root.children.end()) return std::nullopt;
  const Entry* entry = &found->second;
  if (entry->kind == Entry::Kind::kMap) {
    const auto child = entry->children.find(key);
    if (child == entry->children.end()) return std::nullopt;
    entry = &child->second;
  } else if (key != "name") {
    return std::nullopt;
  }
  if (entry->kind != Entry::Kind::kScalar || entry->scalar.empty()) return std::nullopt;
  return entry->scalar;
}

std::vector<ParamRow> ParamSource::LoadWith(void (*call)(void*, ParamVisitor&), void* context) const {
  LoadVisitor visitor(impl_->root);
  call(context, visitor);
  return visitor.TakeRows();
}

std::string DumpYaml(const std::vector<ParamRow>& rows) {
  std::string out;
  std::vector<std::string> open;
  for (const ParamRow& row : rows) {
    std::vector<std::string> keys;
    for (size_t begin = 0; begin <= row.path.size();) {
      const size_t dot = std::min(row.path.find('.', begin), row.path.size());
      keys.push_back(row.path.substr(begin, dot - begin));
      begin = dot + 1;
    }
    size_t depth = 0;
    while (depth + 1 < keys.size() && depth < open.size() && open[depth] == keys[depth]) ++depth;
    open.resize(depth);
    for (; depth + 1 < keys.size(); ++depth) {
      out += fmt::format("{}{}:\n", std::string(2 * depth, ' '), keys[depth]);
      open.push_back(keys[depth]);
    }
    YAML::Emitter scalar;  // quotes where YAML needs it
    if (row.value.starts_with('[')) {
      scalar << YAML::Flow << YAML::Load(row.value);
    } else {
      scalar << row.value;
    }
    out += fmt::format("{}{}: {}\n", std::string(2 * depth, ' '), keys.back(), scalar.c_str());
  }
  return out;
}

}  // namespace atlas::core
