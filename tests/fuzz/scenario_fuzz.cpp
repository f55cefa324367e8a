// Any text is a scenario or an Error{config} of one line, and so is any text as a path.
#include "common/simulator/drive.h"
#include "common/simulator/scenario.h"
#include "tests/fuzz/one_line.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace parloc;
  const std::string text = fuzz::text_of(data, size);
  fuzz::reads_or_says_why(ErrorKind::config, [&] { scenario_from_text(text, "fuzz"); });
  fuzz::reads_or_says_why(ErrorKind::config, [&] {
    const WaypointPath path = waypoints_from_text(text, "fuzz");
    const Drive drive = plan_drive(path);
    const Pose pose = pose_at(drive, 0.5 * drive.duration_s());
    fuzz::require(drive.duration_s() > 0.0 && pose.theta_rad >= -4.0 && pose.theta_rad <= 4.0);
  });
  return 0;
}
