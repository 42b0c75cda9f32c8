// Every experiment that ships can be loaded, its values within their limits.
#include <gtest/gtest.h>

#include "experiments/identity/experiment_config.h"
#include "scenes/catalog.h"

namespace atlas::experiments {
namespace {

TEST(ShippedExperiments, LoadAndNameAScene) {
  const std::vector<ExperimentEntry> experiments = ListExperiments();
  ASSERT_GE(experiments.size(), 7u);
  for (const ExperimentEntry& entry : experiments) {
    SCOPED_TRACE(entry.name);
    EXPECT_FALSE(entry.doc.empty());
    ExperimentConfig config;
    ASSERT_NO_THROW(config = LoadExperiment(entry.name, {}));
    EXPECT_NO_THROW(scenes::LoadScene(config.scene.name));
  }
}

}  // namespace
}  // namespace atlas::experiments
