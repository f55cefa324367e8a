// Any text is a scenario or an Error{config} of one line, and so is any text as a path.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "common/error.h"
#include "common/simulator/drive.h"
#include "common/simulator/scenario.h"

namespace {

template <class Read>
void try_reading(Read&& read) {
  try {
    read();
  } catch (const parloc::Error& e) {
    if (e.kind() != parloc::ErrorKind::config) std::abort();
    if (std::string(e.what()).find('\n') != std::string::npos) std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  try_reading([&] { parloc::scenario_from_text(text, "fuzz"); });
  try_reading([&] {
    const parloc::WaypointPath path = parloc::waypoints_from_text(text, "fuzz");
    const parloc::Drive drive = parloc::plan_drive(path);
    const parloc::Pose pose = parloc::pose_at(drive, 0.5 * drive.duration_s());
    if (!(drive.duration_s() > 0.0) || !(pose.theta_rad >= -4.0 && pose.theta_rad <= 4.0)) std::abort();
  });
  return 0;
}
