// Everything that parloc offers to other programs: #include <parloc/parloc.h> (docs/building.md).
#pragma once

#include "common/config/config.h"
#include "common/config/pose_filters.h"
#include "common/error.h"
#include "common/eval/metrics.h"
#include "common/filter/particle_filter.h"
#include "common/flow/flow_filter.h"
#include "common/inputs/open_log.h"
#include "common/io/log.h"
#include "common/io/trajectory.h"
#include "common/localize/localizer.h"
#include "common/map/grid_map.h"
#include "common/map/map_reader.h"
#include "common/math/pose.h"
#include "common/search/global_search.h"
#include "common/slam/grid_slam.h"
#include "common/slam/slam_checkpoint.h"
