// What a robot log holds, whatever its file format.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/math/pose.h"
#include "common/model/scan.h"

namespace parloc {

/// What a record is.
enum class RecordKind { odometry, scan };

/// One odometry reading, or one scan with the odometry at its time.
struct LogRecord {
  RecordKind kind = RecordKind::odometry;  ///< Whether there is a scan.
  double stamp_s = 0.0;                    ///< The reading's time, or the scan's.
  Pose odometry;                           ///< Pose of the base in the odometry frame.
  Scan scan;                               ///< For kind == scan.
  std::size_t line = 0;                    ///< Where it stands in a text, for messages; else 0.
};

/// Something that a log leaves open or states oddly, of one of its LiDARs: said once, as soon as it is seen.
struct LogNote {
  /// Which angles its beams have, or where it sits on the robot.
  enum class About { angles, mount };
  About about = About::angles;  ///< What is left open.
  std::string lidar;            ///< Scan::sensor.
  std::string text;             ///< One line, with the settings that decide it.
};

/// What a reader worked around. Nothing is dropped without being counted here.
struct LogWarnings {
  std::size_t broken_lines = 0;     ///< Skipped lines; the first few are described in `messages`.
  std::size_t backward_stamps = 0;  ///< A scan's stamp before that of the previous scan (file order is kept).
  std::size_t beam_count_changes =
      0;  ///< A scan with another number of beams than the one before of its sensor.
  std::size_t unknown_messages = 0;  ///< Lines of message types that parloc has no use for.
  /// The same by type, for the first 20 types, in the order of their first lines.
  std::vector<std::pair<std::string, std::size_t>> unread;
  std::vector<LogNote> notes;         ///< At most one of a kind per LiDAR.
  std::vector<std::string> messages;  ///< "file:line: what was expected", at most 20.
};

/// A stream of records in file order.
class LogReader {
 public:
  virtual ~LogReader() = default;
  /// Fills `record` with the next one; false at the end. Broken lines are skipped and counted; never throws
  /// for them.
  virtual bool next(LogRecord& record) = 0;
  /// Of a log that is still being made: next() gave none, but more may come.
  virtual bool waits() const { return false; }
  /// What was worked around so far.
  virtual const LogWarnings& warnings() const = 0;
  /// Fraction of the file read so far, 0 to 1 (compressed bytes for gzip).
  virtual double progress() const = 0;
};

/// Opens a CARMEN text log (ODOM, FLASER, RLASER, ROBOTLASER1 to 9; the PARAM lines of CarmenParams;
/// comments with #), plain or gzip (told apart by content). Where its only scans are RAWLASER1 to 9, which
/// say no odometry, they get that of the ODOM lines at their time (join_odometry()), or, `without_odometry`,
/// none. Throws Error{input} if the file cannot be read.
std::unique_ptr<LogReader> open_carmen_log(const std::string& path, bool without_odometry = false);

/// A CARMEN log already in memory, for tests and fuzzers. `name` stands for the file in messages.
std::unique_ptr<LogReader> carmen_log_from_text(const std::string& text, const std::string& name,
                                                bool without_odometry = false);

/// How many digits a written number has.
enum class CarmenDigits {
  short_form,  ///< Ranges with 4 decimals, stamps with 6.
  all,         ///< As few as read back to the same number.
};
/// Writes one scan as a ROBOTLASER line, its number that of the sensor's name, else 1 (carries angles, limits
/// and the sensor pose), so that open_carmen_log gives it back.
std::string carmen_line(const LogRecord& record, CarmenDigits digits = CarmenDigits::short_form);

}  // namespace parloc
