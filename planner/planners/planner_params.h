// A planner's parameters, and the planner that they make: what each file of this folder defines.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/params.h"
#include "planner/gain/gain.h"
#include "planner/planner.h"
#include "planner/views/planner_setup.h"

namespace atlas::planner {

class PlannerParams {
 public:
  virtual ~PlannerParams() = default;
  virtual void Visit(core::ParamVisitor& v) = 0;
  virtual std::unique_ptr<PlannerParams> Clone() const = 0;
  /// @throws InputError for parameters that make none.
  virtual std::unique_ptr<Planner> Build(const PlannerSetup& setup) const = 0;

  /// Side of the square about the robot that it plans in: the terrain map holds as much unless told.
  virtual double window_m() const { return 16.0; }
  /// The information gain that takes part in its choice; "none" where none does.
  virtual std::string gain() const { return "none"; }
  /// What views are worth where that is more than the gain: named in every table.
  virtual std::string worth() const { return ""; }
  /// Columns of Candidate::extra_gains.
  virtual std::vector<std::string> extra_gains() const { return {}; }
  /// What all its gains read of the map.
  virtual GainReads reads() const { return {}; }
};

/// Clone for a copyable `Params`.
template <typename Params>
class PlannerParamsOf : public PlannerParams {
 public:
  std::unique_ptr<PlannerParams> Clone() const final {
    return std::make_unique<Params>(static_cast<const Params&>(*this));
  }
};

struct PlannerEntry {
  std::string name;
  std::string doc;
  std::unique_ptr<PlannerParams> (*defaults)();
};

}  // namespace atlas::planner
