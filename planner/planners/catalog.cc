#include "planner/planners/catalog.h"

#include <algorithm>
#include <set>
#include <utility>

#include "core/catalog.h"
#include "planner/planners/entries.h"

namespace atlas::planner {
namespace {

/// The names of fields, whatever their type.
class FieldNames final : public core::ParamVisitor {
 public:
  void Field(const std::string& name, double*, const core::ParamInfo&) override { names.insert(name); }
  void Field(const std::string& name, int*, const core::ParamInfo&) override { names.insert(name); }
  void Field(const std::string& name, bool*, const core::ParamInfo&) override { names.insert(name); }
  void Field(const std::string& name, std::string*, const core::ParamInfo&) override { names.insert(name); }
  void Field(const std::string& name, std::vector<std::string>*, const core::ParamInfo&) override {
    names.insert(name);
  }
  std::set<std::string> names;

 private:
  void Enter(const std::string&) override {}
  void Leave() override {}
};

std::set<std::string> FieldsOf(PlannerParams* params) {
  FieldNames visitor;
  params->Visit(visitor);
  return visitor.names;
}

std::string Docs() {
  std::string docs;
  for (const PlannerEntry& entry : PlannerCatalog()) {
    docs += (docs.empty() ? "" : "; ") + entry.name + ": " + entry.doc;
  }
  return docs;
}

}  // namespace

const std::vector<PlannerEntry>& PlannerCatalog() {
  static const std::vector<PlannerEntry> catalog = {
#define ATLAS_PLANNER(Name) Name##Planner(),
#include "planner/planners/catalog.inc"
#undef ATLAS_PLANNER
  };
  return catalog;
}

PlannerConfig::PlannerConfig(const std::string& kind)
    : name(kind), own(core::EntryNamed(PlannerCatalog(), "planner", kind).defaults()) {
  terrain.window_m = own->window_m();
}

PlannerConfig::PlannerConfig(const PlannerConfig& other)
    : name(other.name), own(other.own->Clone()), terrain(other.terrain) {}

PlannerConfig& PlannerConfig::operator=(const PlannerConfig& other) {
  return *this = PlannerConfig(other);
}

void PlannerConfig::Visit(core::ParamVisitor& v) {
  const std::string before = name;
  v.Field("name", &name, {.choices = core::NamesOf(PlannerCatalog()), .doc = Docs()});
  if (name != before) *this = PlannerConfig(name);
  const double window_m = own->window_m();
  own->Visit(v);
  if (own->window_m() != window_m) terrain.window_m = std::max(terrain.window_m, own->window_m());
  const std::set<std::string> here = FieldsOf(own.get());
  for (const PlannerEntry& entry : PlannerCatalog()) {
    for (const std::string& field : FieldsOf(entry.defaults().get())) {
      if (!here.contains(field)) v.Absent(field, "planner.name = " + name);
    }
  }
  v.Section("terrain", &terrain);
}

std::unique_ptr<Planner> MakePlanner(const PlannerConfig& config, PlannerSetup setup) {
  setup.terrain = config.terrain;
  return config.own->Build(setup);
}

}  // namespace atlas::planner
