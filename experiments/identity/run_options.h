// What a run is told besides its configuration: where to write, how to report, when to stop.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

namespace atlas::sim {
class Simulator;
}

namespace atlas::experiments {

struct RunOptions {
  int threads = 1;
  std::filesystem::path folder;  ///< the run folder, written as the run goes
  /// Called once all is built, before the robot moves. Until then the run folder says `interrupted`, and
  /// ending the process loses nothing.
  std::function<void()> prepared = [] {};
  /// Polled while the robot moves and while the video is made; true ends the run as `interrupted`, its folder
  /// valid.
  std::function<bool()> should_stop = [] { return false; };
  /// One line on what is going on, after every stage; `final` lines end a scan.
  std::function<void(const std::string& line, bool final)> progress = [](const std::string&, bool) {};
  /// What stands between the simulator and all who ask it; empty: nothing. For tests that lie to them.
  std::function<std::unique_ptr<sim::Simulator>(std::unique_ptr<sim::Simulator>)> interpose = {};
};

}  // namespace atlas::experiments
