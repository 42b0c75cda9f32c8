// Parameters: one declaration each (name, unit, default, range, meaning). YAML loading, `--set a.b=value`,
// validation, `atlas explain` and the dump in every run folder come from it.
//
//   struct GridParams {
//     double resolution_m = 0.05;
//     void Visit(core::ParamVisitor& v) {
//       v.Field("resolution_m", &resolution_m, {.unit = "m", .min = 0.01, .max = 1.0, .doc = "edge of a
//       voxel"});
//     }
//   };
//
// A struct nests another with v.Section("grid", &grid). Keys ending `_deg` hold degrees in YAML and in the
// field.
#pragma once

#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace atlas::core {

/// Limits are inclusive. `choices`, where given, lists every valid value of a string.
struct ParamInfo {
  std::string unit = "";
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  std::vector<std::string> choices = {};
  std::string doc = "";
  bool is_file = false;  ///< a string that may name a file, relative to the YAML file that it stands in
};

class ParamVisitor {
 public:
  virtual ~ParamVisitor() = default;
  virtual void Field(const std::string& name, double* value, const ParamInfo& info) = 0;
  virtual void Field(const std::string& name, int* value, const ParamInfo& info) = 0;
  virtual void Field(const std::string& name, bool* value, const ParamInfo& info) = 0;
  virtual void Field(const std::string& name, std::string* value, const ParamInfo& info) = 0;
  virtual void Field(const std::string& name, std::vector<std::string>* value, const ParamInfo& info) = 0;
  /// A parameter of other kinds, without effect here; `here` tells where, for the message to who sets it.
  virtual void Absent(const std::string& /*name*/, const std::string& /*here*/) {}

  template <typename Params>
  void Section(const std::string& name, Params* params) {
    Enter(name);
    params->Visit(*this);
    Leave();
  }

 protected:
  virtual void Enter(const std::string& name) = 0;
  virtual void Leave() = 0;
};

/// Visits the fields of other kinds: none is loaded or listed, and setting one is refused in one line that
/// names `here`, as "mapper.name = se_atlas". Of structs without sections.
class AbsentFields : public ParamVisitor {
 public:
  AbsentFields(ParamVisitor* visitor, std::string here) : visitor_(visitor), here_(std::move(here)) {}
  void Field(const std::string& name, double*, const ParamInfo&) override { Absent(name, here_); }
  void Field(const std::string& name, int*, const ParamInfo&) override { Absent(name, here_); }
  void Field(const std::string& name, bool*, const ParamInfo&) override { Absent(name, here_); }
  void Field(const std::string& name, std::string*, const ParamInfo&) override { Absent(name, here_); }
  void Field(const std::string& name, std::vector<std::string>*, const ParamInfo&) override {
    Absent(name, here_);
  }
  void Absent(const std::string& name, const std::string& here) override { visitor_->Absent(name, here); }

 private:
  void Enter(const std::string&) override {}
  void Leave() override {}
  ParamVisitor* visitor_;
  std::string here_;
};

/// One explained parameter: what `atlas explain` prints a row of.
struct ParamRow {
  std::string path;  ///< "mapper.resolution_m"
  std::string value;
  std::string unit;
  std::string range;
  std::string doc;
  std::string origin;  ///< "default", "FILE:LINE" or "--set"
};

/// Layers of YAML (files with `extends:`, then `--set`), merged; later ones win.
class ParamSource {
 public:
  ParamSource();
  ~ParamSource();
  ParamSource(ParamSource&&) noexcept;
  ParamSource& operator=(ParamSource&&) noexcept;

  /// Merges a file over what is here; its `extends: NAME` (a file relative to its folder, or in
  /// `fallback_dir`) comes first.
  /// @throws InputError for a missing file, malformed YAML (file, line) or a cycle of extends.
  void MergeFile(const std::filesystem::path& path, const std::filesystem::path& fallback_dir);
  /// Merges "a.b.c=value" from the command line. @throws InputError when it is not of that form.
  void MergeAssignment(const std::string& assignment);

  /// The text that the layers give "section.key", if any: for defaults that depend on it. A bare scalar for a
  /// section is its name.
  std::optional<std::string> TextAt(const std::string& section, const std::string& key) const;

  /// Fills `params` from the layers. @throws InputError for an unknown key (suggesting the near one), a wrong
  /// type or a value out of range, naming origin, key, value and limit.
  template <typename Params>
  std::vector<ParamRow> Load(Params* params) const {
    return LoadImpl([params](ParamVisitor& v) { params->Visit(v); });
  }

 private:
  struct Impl;
  template <typename Visit>
  std::vector<ParamRow> LoadImpl(const Visit& visit) const;
  std::vector<ParamRow> LoadWith(void (*call)(void*, ParamVisitor&), void* context) const;
  std::unique_ptr<Impl> impl_;
};

template <typename Visit>
std::vector<ParamRow> ParamSource::LoadImpl(const Visit& visit) const {
  return LoadWith([](void* context, ParamVisitor& v) { (*static_cast<const Visit*>(context))(v); },
                  const_cast<void*>(static_cast<const void*>(&visit)));
}

/// The resolved parameters as YAML that loads back to the same values.
std::string DumpYaml(const std::vector<ParamRow>& rows);

}  // namespace atlas::core
