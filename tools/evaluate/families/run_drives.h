// Many drives at once, each driven twice: whole drives are the unit of work.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "common/config/config.h"
#include "common/eval/families/drive_score.h"
#include "tools/evaluate/families/drive_source.h"

namespace parloc::tools::families {

struct DrivesRequest {
  Config config;  ///< Of the closed loop. Its numbers of threads do not count: each localizer has one.
  std::vector<std::size_t> items;  ///< Which drives.
  int jobs = 1;
  bool samples = false;        ///< Whether results keep them; marks they always have.
  std::function<bool()> stop;  ///< Asked often; may be empty.
  /// Told now and then, on the caller's thread; may be empty.
  std::function<void(double fraction, std::size_t finished)> progress;
};

/// Told of each finished drive, by any thread.
using KeepDrive = std::function<void(std::size_t item, double took_s, DriveResult result)>;

/// Both runs of a drive have its seed. The first error of any, or of `keep`, ends the work and is thrown.
void run_drives(const DrivesRequest& request, const DriveSource& source, const KeepDrive& keep);
/// The finished drives in the order of the items, whatever the number of jobs; all, unless `stop` said so.
std::vector<DriveResult> run_drives(const DrivesRequest& request, const DriveSource& source);

}  // namespace parloc::tools::families
