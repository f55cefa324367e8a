#include "common/ros/message_definitions.h"

#include <algorithm>
#include <string_view>
#include <vector>

#include "common/error.h"

namespace parloc {

namespace {

struct Definition {
  std::string_view type;  ///< "package/Name"
  std::string_view fields;
};

/// ROS 2 Humble's, without comments; nav2_msgs from nav2. A type stands after those within it.
constexpr Definition kDefinitions[] = {
    {"builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"},
    {"std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"},
    {"geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Quaternion", "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"},
    {"geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"},
    {"geometry_msgs/PoseStamped", "std_msgs/Header header\ngeometry_msgs/Pose pose\n"},
    {"geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n"},
    {"geometry_msgs/PoseWithCovarianceStamped",
     "std_msgs/Header header\ngeometry_msgs/PoseWithCovariance pose\n"},
    {"geometry_msgs/Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"},
    {"geometry_msgs/TwistWithCovariance", "geometry_msgs/Twist twist\nfloat64[36] covariance\n"},
    {"geometry_msgs/Transform", "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"},
    {"geometry_msgs/TransformStamped",
     "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"},
    {"tf2_msgs/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"},
    {"sensor_msgs/LaserScan",
     "std_msgs/Header header\nfloat32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\n"
     "float32 time_increment\nfloat32 scan_time\nfloat32 range_min\nfloat32 range_max\n"
     "float32[] ranges\nfloat32[] intensities\n"},
    {"nav_msgs/Odometry",
     "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
     "geometry_msgs/TwistWithCovariance twist\n"},
    {"nav_msgs/MapMetaData",
     "builtin_interfaces/Time map_load_time\nfloat32 resolution\nuint32 width\nuint32 height\n"
     "geometry_msgs/Pose origin\n"},
    {"nav_msgs/OccupancyGrid", "std_msgs/Header header\nnav_msgs/MapMetaData info\nint8[] data\n"},
    {"nav_msgs/Path", "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n"},
    {"nav2_msgs/Particle", "geometry_msgs/Pose pose\nfloat64 weight\n"},
    {"nav2_msgs/ParticleCloud", "std_msgs/Header header\nnav2_msgs/Particle[] particles\n"},
    {"diagnostic_msgs/KeyValue", "string key\nstring value\n"},
    {"diagnostic_msgs/DiagnosticStatus",
     "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\nstring message\n"
     "string hardware_id\ndiagnostic_msgs/KeyValue[] values\n"},
    {"diagnostic_msgs/DiagnosticArray",
     "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n"},
};

/// "package/Name" of "package/msg/Name".
std::string short_name(const std::string& type) {
  const std::size_t at = type.find("/msg/");
  return at == std::string::npos ? type : type.substr(0, at) + type.substr(at + 4);
}

const Definition& definition_of(std::string_view type) {
  for (const Definition& definition : kDefinitions)
    if (definition.type == type) return definition;
  throw Error(ErrorKind::internal, "no definition of " + std::string(type));
}

/// Adds the types of its fields that have fields of their own, each once, what is within them after it.
void add_types_within(const Definition& definition, std::vector<std::string_view>& types) {
  std::string_view rest = definition.fields;
  while (!rest.empty()) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(line.size() + 1);
    const std::string_view type = line.substr(0, line.find_first_of(" ["));
    const bool known = std::find(types.begin(), types.end(), type) != types.end();
    if (type.find('/') == std::string_view::npos || known) continue;
    types.push_back(type);
    add_types_within(definition_of(type), types);
  }
}

}  // namespace

std::string message_definition(const std::string& type) {
  const Definition& whole = definition_of(short_name(type));
  std::vector<std::string_view> types;
  add_types_within(whole, types);
  std::string text(whole.fields);
  for (const std::string_view within : types) {
    text += std::string(80, '=') + "\nMSG: ";
    text += within;
    text += "\n";
    text += definition_of(within).fields;
  }
  return text;
}

}  // namespace parloc
