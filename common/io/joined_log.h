// A log whose scans come without odometry, with the odometry at their time.
#pragma once

#include <memory>
#include <string>

#include "common/io/log.h"

namespace parloc {

/// The records of `log`, its scans' odometry between the readings before and after them (OdometryJoiner), all
/// in the order of their stamps. Scans outside are left out, and told in the warnings. next() throws
/// Error{input} naming the log at the end if none lies between readings.
std::unique_ptr<LogReader> join_odometry(std::unique_ptr<LogReader> log, std::string name);

}  // namespace parloc
