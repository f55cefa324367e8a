#include "common/io/log_notes.h"

#include "common/model/lidar.h"

namespace parloc {

std::vector<std::string> open_notes(const std::vector<LogNote>& notes,
                                    const std::vector<LidarConfig>& lidars) {
  std::vector<std::string> texts;
  for (const LogNote& note : notes) {
    const LidarConfig* lidar = find_lidar(lidars, note.lidar);
    const bool settled =
        lidar != nullptr && (note.about == LogNote::About::angles ? lidar->angle_min && lidar->angle_step
                                                                  : lidar->x && lidar->y && lidar->yaw);
    if (!settled) texts.push_back(note.text);
  }
  return texts;
}

}  // namespace parloc
