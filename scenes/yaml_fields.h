// Checked reading of a user's YAML: every problem becomes one line "FILE:LINE: field: what is wrong".
#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/geometry.h"

namespace atlas::scenes {

/// A mapping in a YAML file, and where it stands. Every reader throws InputError for a missing field (unless
/// a default is given), a wrong type or a number that is not finite.
class YamlFields {
 public:
  /// The whole file. @throws InputError when it is missing, malformed, or not a mapping.
  static YamlFields FromFile(const std::filesystem::path& file);

  bool Has(const std::string& key) const { return node_[key].IsDefined(); }
  /// Rejects keys other than these, suggesting the near one.
  void AllowOnly(const std::vector<std::string>& keys) const;

  double Number(const std::string& key) const;
  double Number(const std::string& key, double otherwise) const { return Has(key) ? Number(key) : otherwise; }
  double Positive(const std::string& key) const;
  bool Flag(const std::string& key, bool otherwise) const;
  std::string Text(const std::string& key) const;
  std::string Text(const std::string& key, const std::string& otherwise) const {
    return Has(key) ? Text(key) : otherwise;
  }
  /// Text that may go over several lines of the file: line ends become blanks.
  std::string Prose(const std::string& key, const std::string& otherwise) const;
  /// A list of exactly `size` numbers.
  Eigen::VectorXd Numbers(const std::string& key, int size) const;

  YamlFields Child(const std::string& key) const;
  std::vector<YamlFields> Children(const std::string& key) const;

  /// @throws InputError "FILE:LINE: path.key: what"; an empty key names the mapping itself.
  [[noreturn]] void Fail(const std::string& key, const std::string& what) const;

  const std::filesystem::path& file() const { return file_; }

 private:
  YamlFields(std::filesystem::path file, std::string path, YAML::Node node);
  YAML::Node Required(const std::string& key) const;
  void RefuseControlCharacters(const std::string& key, const std::string& text) const;

  std::filesystem::path file_;
  std::string path_;  ///< "parts[2]."
  YAML::Node node_;
};

}  // namespace atlas::scenes
