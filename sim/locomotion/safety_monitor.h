// Counts what must not happen: falls, collisions, footholds off solid ground.
#pragma once

#include "sim/locomotion/trot_controller.h"
#include "sim/simulator.h"
#include "sim/world/world.h"

namespace atlas::sim {

class SafetyMonitor {
 public:
  /// Call once a step, after physics.
  void OnStep(const World& world, const TrotController& controller);

  const SafetyCounts& counts() const { return counts_; }
  bool fallen() const { return fallen_; }

 private:
  /// Contacts closer together than 0.5 s are one episode.
  struct Episode {
    double last_s = -1e9;
    bool Starts(double time_s);
  };

  SafetyCounts counts_;
  bool fallen_ = false;
  Episode collision_, brush_;
};

}  // namespace atlas::sim
