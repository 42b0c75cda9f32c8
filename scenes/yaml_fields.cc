#include "scenes/yaml_fields.h"

#include <fmt/format.h>

#include <utility>

#include "core/errors.h"
#include "core/safe_text.h"
#include "core/yaml_text.h"

namespace atlas::scenes {
namespace {

/// Of any number: scenes are metres and degrees about their origin.
constexpr double kGreatest = 1e4;

std::string Shown(const YAML::Node& node) {
  if (node.IsScalar()) return "'" + node.Scalar() + "'";
  return node.IsSequence() ? "a list" : node.IsMap() ? "a mapping" : "nothing";
}

}  // namespace

YamlFields::YamlFields(std::filesystem::path file, std::string path, YAML::Node node)
    : file_(std::move(file)), path_(std::move(path)), node_(std::move(node)) {
  if (!node_.IsMap()) Fail("", fmt::format("expected a mapping of fields, found {}", Shown(node_)));
}

YamlFields YamlFields::FromFile(const std::filesystem::path& file) {
  return YamlFields(file, "", core::LoadYaml(file));
}

void YamlFields::Fail(const std::string& key, const std::string& what) const {
  const YAML::Node at = !key.empty() && node_.IsMap() && Has(key) ? node_[key] : node_;
  std::string where = path_ + key;
  if (key.empty() && !where.empty()) where.pop_back();
  throw core::InputError(fmt::format("{}:{}: {}{}{}", file_.string(), std::max(at.Mark().line, 0) + 1, where,
                                     where.empty() ? "" : ": ", what));
}

void YamlFields::AllowOnly(const std::vector<std::string>& keys) const {
  for (const auto& entry : node_) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "";
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    const std::string within = path_.empty() ? "" : path_.substr(0, path_.size() - 1) + ": ";
    throw core::InputError(fmt::format("{}:{}: {}{}", file_.string(), entry.first.Mark().line + 1, within,
                                       core::UnknownName("key", key, keys)));
  }
}

YAML::Node YamlFields::Required(const std::string& key) const {
  if (!Has(key)) Fail("", fmt::format("missing field '{}'", key));
  return node_[key];
}

double YamlFields::Number(const std::string& key) const {
  const YAML::Node node = Required(key);
  double value = 0.0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, value)) {
    Fail(key, fmt::format("expected a number, found {}", Shown(node)));
  }
  if (!std::isfinite(value)) Fail(key, fmt::format("{} is not finite", node.Scalar()));
  if (std::abs(value) > kGreatest) Fail(key, fmt::format("{} is beyond {:g}", node.Scalar(), kGreatest));
  return value;
}

double YamlFields::Positive(const std::string& key) const {
  const double value = Number(key);
  if (!(value > 0.0)) Fail(key, fmt::format("{} is out of range (must be above 0)", value));
  return value;
}

bool YamlFields::Flag(const std::string& key, bool otherwise) const {
  if (!Has(key)) return otherwise;
  bool value = otherwise;
  if (!node_[key].IsScalar() || !YAML::convert<bool>::decode(node_[key], value)) {
    Fail(key, fmt::format("expected true or false, found {}", Shown(node_[key])));
  }
  return value;
}

std::string YamlFields::Text(const std::string& key) const {
  const YAML::Node node = Required(key);
  if (!node.IsScalar() || node.Scalar().empty())
    Fail(key, fmt::format("expected text, found {}", Shown(node)));
  RefuseControlCharacters(key, node.Scalar());
  return node.Scalar();
}

std::string YamlFields::Prose(const std::string& key, const std::string& otherwise) const {
  if (!Has(key)) return otherwise;
  if (!node_[key].IsScalar()) Fail(key, fmt::format("expected text, found {}", Shown(node_[key])));
  std::string text = node_[key].Scalar();
  std::replace(text.begin(), text.end(), '\n', ' ');
  RefuseControlCharacters(key, text);
  return text;
}

void YamlFields::RefuseControlCharacters(const std::string& key, const std::string& text) const {
  if (core::HasControlCharacters(text)) Fail(key, fmt::format("holds a control character: '{}'", text));
}

Eigen::VectorXd YamlFields::Numbers(const std::string& key, int size) const {
  const YAML::Node node = Required(key);
  if (!node.IsSequence() || static_cast<int>(node.size()) != size) {
    Fail(key, fmt::format("expected a list of {} numbers, found {}", size,
                          node.IsSequence() ? fmt::format("{} entries", node.size()) : Shown(node)));
  }
  Eigen::VectorXd values(size);
  for (int k = 0; k < size; ++k) {
    const YAML::Node entry = node[static_cast<size_t>(k)];
    if (!entry.IsScalar() || !YAML::convert<double>::decode(entry, values[k])) {
      Fail(key, fmt::format("entry {}: expected a number, found {}", k + 1, Shown(entry)));
    }
    if (!std::isfinite(values[k]))
      Fail(key, fmt::format("entry {}: {} is not finite", k + 1, entry.Scalar()));
    if (std::abs(values[k]) > kGreatest)
      Fail(key, fmt::format("entry {}: {} is beyond {:g}", k + 1, entry.Scalar(), kGreatest));
  }
  return values;
}

YamlFields YamlFields::Child(const std::string& key) const {
  return YamlFields(file_, path_ + key + ".", Required(key));
}

std::vector<YamlFields> YamlFields::Children(const std::string& key) const {
  const YAML::Node node = Required(key);
  if (!node.IsSequence()) Fail(key, fmt::format("expected a list, found {}", Shown(node)));
  std::vector<YamlFields> children;
  for (size_t k = 0; k < node.size(); ++k) {
    children.push_back(YamlFields(file_, fmt::format("{}{}[{}].", path_, key, k), node[k]));
  }
  return children;
}

}  // namespace atlas::scenes
