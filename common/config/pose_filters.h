// Every filter that tracks a pose from a known start, by its name.
#pragma once

#include <array>
#include <memory>
#include <string_view>

#include "common/config/config.h"
#include "common/filter/pose_filter.h"
#include "common/map/grid_map.h"

namespace parloc {

/// What make_pose_filter knows, in the order in which a table should have them.
inline constexpr std::array<std::string_view, 9> kPoseFilterNames{
    "mcl", "amcl", "ekf", "ekf_beams", "edh", "naedh", "ledh", "gromov", "pfpf"};

/// mcl: the particle filter with a fixed number of particles; amcl: the same with one that adapts, 500 to
/// 3000 unless the configuration says otherwise. The others: common/flow/flow_filter.h. Throws Error{config}
/// for another name or an impossible configuration, Error{backend}, and Error{input} for a map without free
/// cells.
std::unique_ptr<PoseFilter> make_pose_filter(std::string_view name, const Config& config, const GridMap& map);

}  // namespace parloc
