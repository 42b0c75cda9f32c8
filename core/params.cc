#include "core/params.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include <charconv>
#include <functional>
#include <map>
#include <set>

#include "core/errors.h"
#include "core/files.h"
#include "core/named_files.h"
#include "core/safe_text.h"

namespace atlas::core {
namespace fs = std::filesystem;
namespace {

/// A value as the user wrote it, and where.
struct Entry {
  enum class Kind { kScalar, kSequence, kMap } kind = Kind::kMap;
  std::string origin;
  fs::path folder = {};  ///< of the file; empty for the command line
  std::string scalar;
  std::vector<std::string> sequence;
  std::map<std::string, Entry> children;
};

/// A value or key; where it goes (names of files, scripts, terminals), control characters would act.
std::string TextOf(const YAML::Node& node, const std::string& origin) {
  std::string text = node.as<std::string>();
  RefuseControlCharacters(text, origin);
  return text;
}

Entry FromYaml(const YAML::Node& node, const std::string& file, const fs::path& folder) {
  Entry entry;
  entry.folder = folder;
  entry.origin = fmt::format("{}:{}", file, node.Mark().line + 1);
  if (node.IsMap()) {
    for (const auto& item : node) {
      Entry child = FromYaml(item.second, file, folder);
      child.origin = fmt::format("{}:{}", file, item.first.Mark().line + 1);
      entry.children[TextOf(item.first, child.origin)] = std::move(child);
    }
  } else if (node.IsSequence()) {
    entry.kind = Entry::Kind::kSequence;
    for (const auto& item : node) {
      if (!item.IsScalar()) throw InputError(fmt::format("{}: a list holds plain values only", entry.origin));
      entry.sequence.push_back(TextOf(item, entry.origin));
    }
  } else {
    entry.kind = Entry::Kind::kScalar;
    if (node.IsScalar()) entry.scalar = TextOf(node, entry.origin);
  }
  return entry;
}

YAML::Node ParseYaml(const std::string& text, const std::string& file) {
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw InputError(fmt::format("{}:{}: malformed YAML: {}", file, error.mark.line + 1, error.msg));
  }
}

/// Merges `over` into `base`; a bare scalar for a section is shorthand for its name.
void Merge(Entry* base, Entry over) {
  if (over.kind == Entry::Kind::kMap) {
    if (base->kind == Entry::Kind::kScalar) {
      Entry name = *base;
      *base = Entry{};
      base->children["name"] = std::move(name);
    } else if (base->kind == Entry::Kind::kSequence) {
      *base = Entry{};
    }
    base->origin = over.origin;
    for (auto& [key, child] : over.children) {
      const auto found = base->children.find(key);
      if (found == base->children.end()) {
        base->children.emplace(key, std::move(child));
      } else {
        Merge(&found->second, std::move(child));
      }
    }
  } else if (over.kind == Entry::Kind::kScalar && base->kind == Entry::Kind::kMap &&
             !base->children.empty()) {
    base->children["name"] = std::move(over);
  } else {
    *base = std::move(over);
  }
}

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
    const std::string got = entry.kind == Entry::Kind::kScalar     ? fmt::format("'{}'", entry.scalar)
                            : entry.kind == Entry::Kind::kSequence ? "a list"
                                                                   : "a section";
    throw InputError(fmt::format("{}: {}: expected {}, got {}", entry.origin, Path(name), wanted, got));
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
                                                : fmt::format("; did you mean '{}'?", near)));
    }
  }

  std::vector<Level> stack_;
  std::vector<std::unique_ptr<Entry>> shorthand_;
  std::vector<ParamRow> rows_;
};

}  // namespace

struct ParamSource::Impl {
  Entry root;
  std::vector<std::string> open_files;  // the chain of `extends`, to find cycles
};

ParamSource::ParamSource() : impl_(std::make_unique<Impl>()) {}
ParamSource::~ParamSource() = default;
ParamSource::ParamSource(ParamSource&&) noexcept = default;
ParamSource& ParamSource::operator=(ParamSource&&) noexcept = default;

void ParamSource::MergeFile(const fs::path& path, const fs::path& fallback_dir) {
  const std::string name = path.string();
  if (std::find(impl_->open_files.begin(), impl_->open_files.end(), name) != impl_->open_files.end()) {
    throw InputError(
        fmt::format("{}: extends itself through {}", name, fmt::join(impl_->open_files, " -> ")));
  }
  const YAML::Node yaml = ParseYaml(ReadFile(path), name);
  if (!yaml.IsMap() && !yaml.IsNull())
    throw InputError(fmt::format("{}:1: expected sections, such as 'scene: car'", name));
  Entry entry = FromYaml(yaml, name, path.parent_path());
  if (const auto extends = entry.children.find("extends"); extends != entry.children.end()) {
    const std::string& given = extends->second.scalar;
    const std::string base = given.ends_with(".yaml") ? given : given + ".yaml";
    fs::path base_path = path.parent_path() / base;
    if (!fs::exists(base_path)) base_path = fallback_dir / base;
    if (!fs::exists(base_path)) {
      throw InputError(fmt::format("{}: extends '{}', but there is no {}", extends->second.origin,
                                   extends->second.scalar, base_path.string()));
    }
    entry.children.erase(extends);
    impl_->open_files.push_back(name);
    MergeFile(base_path, fallback_dir);
    impl_->open_files.pop_back();
  }
  Merge(&impl_->root, std::move(entry));
}

void ParamSource::MergeAssignment(const std::string& assignment) {
  RefuseControlCharacters(assignment, "--set");
  const size_t equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw InputError(fmt::format("--set {}: expected section.key=value", assignment));
  }
  Entry entry = FromYaml(ParseYaml(assignment.substr(equals + 1), "--set " + assignment), "--set", {});
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
  Merge(&impl_->root, std::move(entry));
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
