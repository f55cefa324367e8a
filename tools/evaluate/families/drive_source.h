// Where the drives of families come from: drawn and simulated, or a recorded log whose odometry is made
// worse.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/eval/families/drive_score.h"
#include "common/eval/families/family.h"
#include "common/eval/families/family_trial.h"
#include "common/io/log_choice.h"

namespace parloc::tools::families {

/// A drive that nobody has driven yet.
struct PreparedDrive {
  FamilyTrial trial;
  DriveResult result;  ///< What is known of it beforehand.
};

struct DriveSource {
  std::string what;  ///< For people.
  std::size_t drives = 0;
  std::function<PreparedDrive(std::size_t index)> prepare;  ///< May be called from several threads.
};

/// `trials` drives of each family, with the seeds from `first_seed` on, on the maps in `folder`.
DriveSource drawn_drives(const std::string& folder, const std::vector<Family>& families,
                         std::uint64_t first_seed, std::size_t trials);

struct RecordedDrives {
  std::string log, truth, map;  ///< Files.
  std::string corrupt;          ///< corruption_from_text(); its seeds are the drives.
  double duration_s = 0.0;      ///< 0: to the end of the log.
  LogChoice choice{};           ///< Of a bag.
};
/// The log from its first scan with a true pose on, whose start is given. Reads all files. Throws
/// Error{input} as their readers, and for a truth of another time; Error{usage} for `corrupt`.
DriveSource recorded_drives(const RecordedDrives& plan, std::uint64_t first_seed, std::size_t trials);

}  // namespace parloc::tools::families
