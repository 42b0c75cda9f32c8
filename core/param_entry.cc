#include "core/param_entry.h"

#include <fmt/format.h>

#include <utility>

#include "core/errors.h"
#include "core/safe_text.h"

namespace atlas::core {
namespace {

/// A value or key; where it goes (names of files, scripts, terminals), control characters would act.
std::string PlainText(const YAML::Node& node, const std::string& origin) {
  RefuseControlCharacters(node.Scalar(), origin);
  return node.Scalar();
}

}  // namespace

std::string KindText(const ParamEntry& entry) {
  if (entry.kind == ParamEntry::Kind::kScalar) return fmt::format("'{}'", entry.scalar);
  return entry.kind == ParamEntry::Kind::kSequence ? "a list" : "a section";
}

ParamEntry EntryFromYaml(const YAML::Node& node, const std::string& file,
                         const std::filesystem::path& folder) {
  ParamEntry entry;
  entry.folder = folder;
  entry.origin = fmt::format("{}:{}", file, node.Mark().line + 1);
  if (node.IsMap()) {
    for (const auto& item : node) {
      ParamEntry child = EntryFromYaml(item.second, file, folder);
      child.origin = fmt::format("{}:{}", file, item.first.Mark().line + 1);
      std::string key = PlainText(item.first, child.origin);
      entry.children[std::move(key)] = std::move(child);
    }
  } else if (node.IsSequence()) {
    entry.kind = ParamEntry::Kind::kSequence;
    for (const auto& item : node) {
      if (!item.IsScalar()) throw InputError(fmt::format("{}: a list holds plain values only", entry.origin));
      entry.sequence.push_back(PlainText(item, entry.origin));
    }
  } else {
    entry.kind = ParamEntry::Kind::kScalar;
    entry.is_null = !node.IsScalar();
    if (node.IsScalar()) entry.scalar = PlainText(node, entry.origin);
  }
  return entry;
}

void MergeEntry(ParamEntry* base, ParamEntry over) {
  if (over.kind == ParamEntry::Kind::kMap) {
    if (base->kind == ParamEntry::Kind::kScalar) {
      ParamEntry name = *base;
      *base = ParamEntry{};
      base->children["name"] = std::move(name);
    } else if (base->kind == ParamEntry::Kind::kSequence) {
      *base = ParamEntry{};
    }
    base->origin = over.origin;
    for (auto& [key, child] : over.children) {
      const auto found = base->children.find(key);
      if (found == base->children.end()) {
        base->children.emplace(key, std::move(child));
      } else {
        MergeEntry(&found->second, std::move(child));
      }
    }
  } else if (over.kind == ParamEntry::Kind::kScalar && base->kind == ParamEntry::Kind::kMap &&
             !base->children.empty()) {
    base->children["name"] = std::move(over);
  } else {
    *base = std::move(over);
  }
}

}  // namespace atlas::core
