#include <fmt/format.h>

#include <iostream>

#include "core/errors.h"
#include "core/stopwatch.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/interrupt.h"
#include "experiments/cli/progress_line.h"
#include "experiments/record/dataset_writer.h"

namespace atlas::experiments {
namespace {

RecordOptions OptionsOf(const RecordArguments& arguments) {
  RecordOptions options;
  options.scene = arguments.scene;
  options.route = arguments.route;
  options.lidar = arguments.lidar;
  options.scans = arguments.scans;
  options.rate_hz = arguments.rate_hz;
  options.speed_m_s = arguments.speed_m_s;
  options.seed = arguments.seed;
  options.noise = arguments.noise == "on";
  options.threads = arguments.threads;
  return options;
}

}  // namespace

int RecordCommand(const RecordArguments& arguments) {
  if (arguments.noise != "on" && arguments.noise != "off") {
    throw core::InputError(core::UnknownName("--noise", arguments.noise, {"on", "off"}));
  }
  const std::filesystem::path folder =
      arguments.out.empty()
          ? std::filesystem::path("runs") / "record" / std::filesystem::path(arguments.scene).stem()
          : arguments.out;
  DatasetRecorder recorder(OptionsOf(arguments));
  const double spacing_m = arguments.truth_spacing_m.value_or(recorder.scene().truth_spacing_m);
  StopInOrderOnSignal();
  ProgressLine line;
  const core::Stopwatch wall;
  const DatasetCounts counts = WriteDataset(&recorder, folder, spacing_m, [&](size_t done, size_t all) {
    const bool last = done == all;
    line.Show(fmt::format("scan {}/{}  {:3.0f} %{}", done, all,
                          100.0 * static_cast<double>(done) / static_cast<double>(all),
                          last && spacing_m > 0.0 ? "  sampling the truth" : ""),
              last);
    return !Interrupted();
  });
  const double rays = static_cast<double>(counts.hits + counts.voids + counts.dropouts);
  std::cout << fmt::format(
      "{}: {} scans of {} x {} over {:.0f} m ({:.1f} s): {:.1f} % hits, {:.1f} % void, {:.2f} % dropouts; {} "
      "truth "
      "points; {:.1f} s\n",
      folder.string(), counts.scans, recorder.lidar().rows(), recorder.lidar().columns, recorder.length_m(),
      recorder.trajectory().poses().back().time_s, 100.0 * static_cast<double>(counts.hits) / rays,
      100.0 * static_cast<double>(counts.voids) / rays, 100.0 * static_cast<double>(counts.dropouts) / rays,
      counts.truth_points, wall.seconds());
  return counts.interrupted ? 130 : 0;
}

}  // namespace atlas::experiments
