// What the planner decided after each scan, and why.
#include "experiments/judge/metrics/entries.h"
#include "experiments/results/run_recorder.h"

namespace atlas::experiments {
namespace {

class Decisions final : public Metric {
 public:
  void OnScan(const JudgedScan& scan, core::Row* step, core::Row*) override {
    const planner::DecisionLog& log = scan.log;
    static const planner::Candidate kNone;
    const planner::Candidate& best = log.best < 0 ? kNone : log.candidates[static_cast<size_t>(log.best)];
    step->Set("outcome", core::Cell(std::string(NameOf(scan.decision))));
    step->Set("candidates", log.views_predicted);
    step->Set("nodes", log.nodes_obtained);
    step->Set("rays", log.rays_traced);
    step->Set("gain", best.gain);
    step->Set("utility", best.utility);
    step->Set("utility_ratio", log.utility_ratio);
    step->Set("path_length_m", log.path_length_m);
    blocked_ = log.blocked ? std::optional(log.blocked->size()) : std::nullopt;
  }
  void Summarise(const JudgedRun&, core::Row* summary) const override {
    summary->Set("blocked_ways", blocked_);
  }

 private:
  std::optional<size_t> blocked_;  ///< of the latest plan
};

}  // namespace

MetricEntry DecisionMetric() {
  using Format = core::Column::Format;
  return {
      .name = "decision",
      .doc = "what the planner chose, of how many views, and what it left out",
      .steps =
          {{"outcome", "", "view, or how the mission ends: gain_exhausted, surface_flat ..."},
           {"candidates", "", "views predicted; empty where the planner predicts none"},
           {"nodes", "", "places found"},
           {"rays", "", "traced"},
           {"gain", "",
            "information gain of the chosen view, in its own unit; empty where none was chosen or predicted",
            6, Format::kSignificant},
           {"utility", "", "of the chosen view (Eq. 3.1); empty where that does not decide", 6,
            Format::kSignificant},
           {"utility_ratio", "", "the best over the greatest so far; empty where utility does not decide"},
           {"path_length_m", "m", "of the way to the chosen view", 4}},
      .summary =
          {{"blocked_ways", "",
            "ways too narrow for the robot, known at the end; left out where the planner looks for none"}},
      .build = BuildMetric<Decisions>};
}

}  // namespace atlas::experiments
