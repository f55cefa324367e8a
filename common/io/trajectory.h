// Trajectories in TUM format, "timestamp x y z qx qy qz qw" per line, # comments; and as FLASER lines.
#pragma once

#include <string>

#include "common/model/trajectory.h"

namespace parloc {

/// TUM, or a CARMEN log, told apart by the first line: there each FLASER line gives its first pose (with 0
/// ranges it is the robot's: so SLAM programs write trajectories for the relation metric), and other messages
/// are skipped. Throws Error{input} with file:line for an unreadable file, a line that is not 8 numbers (or
/// no whole FLASER line), a quaternion far from unit length, or a file without a pose.
Trajectory read_tum(const std::string& path);
/// The same from a text in memory; `name` stands for the file in messages.
Trajectory tum_from_text(const std::string& text, const std::string& name);

/// Stamps with 6 decimals, one row per pose, written to a temporary file that is renamed. Throws
/// Error{output}.
void write_tum(const std::string& path, const Trajectory& trajectory);

}  // namespace parloc
