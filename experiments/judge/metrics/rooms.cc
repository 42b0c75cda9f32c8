// Whether each room has a submap of its own (thesis 4.10.6, 4.10.7).
#include "experiments/judge/metrics/entries.h"

namespace atlas::experiments {
namespace {

class Rooms final : public Metric {
 public:
  void OnScan(const JudgedScan&, core::Row*, core::Row*) override {}
  void Summarise(const JudgedRun& run, core::Row* summary) const override {
    if (!run.rooms) return;
    summary->Set("rooms_precision", run.rooms->precision);
    summary->Set("rooms_recall", run.rooms->recall);
    summary->Set("rooms_rand", run.rooms->adjusted_rand);
    summary->Set("rooms_visited", run.rooms->rooms);
    summary->Set("rooms_shared", run.rooms->rooms_shared);
  }
};

}  // namespace

MetricEntry RoomsMetric() {
  return {.name = "rooms",
          .doc = "keyframes by submap and by true room, in scenes that tell their rooms",
          .summary = {{"rooms_precision", "", "of a submap's keyframes in its main room, mean over submaps"},
                      {"rooms_recall", "", "of a room's keyframes in its main submap, mean over rooms"},
                      {"rooms_rand", "", "adjusted Rand index of the two partitions"},
                      {"rooms_visited", "", "rooms with a keyframe"},
                      {"rooms_shared", "", "rooms whose main submap is another room's, too"}},
          .build = BuildMetric<Rooms>};
}

}  // namespace atlas::experiments
