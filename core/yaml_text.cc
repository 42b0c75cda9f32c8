#include "core/yaml_text.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <vector>

#include "core/errors.h"
#include "core/files.h"

namespace atlas::core {
namespace {

/// Judges a document by its events, before any node is built.
class YamlCheck : public YAML::EventHandler {
 public:
  explicit YamlCheck(const std::string& where) : where_(where) {}

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ > 1) Fail(mark, "a second document (a file holds one)");
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    Begin(mark, nullptr);
    Finish(anchor, {1, 0});
  }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                const std::string& value) override {
    Begin(mark, &value);
    Finish(anchor, {1, 0});
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    Begin(mark, nullptr);
    const auto named = anchored_.find(anchor);
    if (named == anchored_.end()) Fail(mark, "an alias stands inside of what it names");
    Count(mark, named->second.nodes - 1);
    CheckDepth(mark, open_.size() + named->second.height);
    Finish(YAML::NullAnchor, named->second);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    Open(mark, anchor, false);
  }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    Open(mark, anchor, true);
  }
  void OnSequenceEnd() override { Close(); }
  void OnMapEnd() override { Close(); }

 private:
  struct Extent {
    size_t nodes = 0;
    size_t height = 0;  ///< levels of lists and mappings
  };
  struct Collection {
    bool is_map = false;
    bool at_key = true;  ///< of a mapping: a key comes next
    YAML::anchor_t anchor = YAML::NullAnchor;
    size_t nodes_before = 0;
    size_t height = 1;
    std::map<std::string, int> keys;  ///< and their lines
  };

  /// A node; `text` where it is plain.
  void Begin(const YAML::Mark& mark, const std::string* text) {
    Count(mark, 1);
    if (open_.empty() || !open_.back().is_map) return;
    Collection& map = open_.back();
    if (map.at_key) {
      if (text == nullptr) Fail(mark, "a key must be plain text");
      const auto [first, added] = map.keys.emplace(*text, mark.line + 1);
      if (!added)
        Fail(mark, fmt::format("the key '{}' stands twice (first in line {})", *text, first->second));
    }
    map.at_key = !map.at_key;
  }
  void Finish(YAML::anchor_t anchor, const Extent& extent) {
    if (anchor != YAML::NullAnchor) anchored_[anchor] = extent;
    if (!open_.empty()) open_.back().height = std::max(open_.back().height, extent.height + 1);
  }
  void Open(const YAML::Mark& mark, YAML::anchor_t anchor, bool is_map) {
    Begin(mark, nullptr);
    CheckDepth(mark, open_.size() + 1);
    open_.push_back({.is_map = is_map, .anchor = anchor, .nodes_before = nodes_ - 1, .keys = {}});
  }
  void Close() {
    const Extent extent{nodes_ - open_.back().nodes_before, open_.back().height};
    const YAML::anchor_t anchor = open_.back().anchor;
    open_.pop_back();
    Finish(anchor, extent);
  }
  void Count(const YAML::Mark& mark, size_t more) {
    nodes_ += more;
    if (nodes_ > kMostYamlNodes) Fail(mark, fmt::format("more than {} values and keys", kMostYamlNodes));
  }
  void CheckDepth(const YAML::Mark& mark, size_t depth) const {
    if (depth > kMostYamlDepth) Fail(mark, fmt::format("nested deeper than {} levels", kMostYamlDepth));
  }
  [[noreturn]] void Fail(const YAML::Mark& mark, const std::string& what) const {
    throw InputError(fmt::format("{}:{}: {}", where_, mark.line + 1, what));
  }

  std::string where_;
  std::vector<Collection> open_;
  std::map<YAML::anchor_t, Extent> anchored_;  ///< of nodes that have ended
  size_t nodes_ = 0;
  int documents_ = 0;
};

}  // namespace

YAML::Node ParseYaml(const std::string& text, const std::string& where) {
  try {
    std::istringstream in(text);
    YAML::Parser parser(in);
    YamlCheck check(where);
    while (parser.HandleNextDocument(check)) continue;
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw InputError(
        fmt::format("{}:{}: malformed YAML: {}", where, std::max(error.mark.line, 0) + 1, error.msg));
  }
}

YAML::Node LoadYaml(const std::filesystem::path& file) {
  constexpr uintmax_t kMostBytes = 16u << 20;
  return ParseYaml(ReadFile(file, kMostBytes), file.string());
}

}  // namespace atlas::core
