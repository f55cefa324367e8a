// The table of settings of grid SLAM.
#pragma once

#include <string>

#include "common/settings/setting.h"
#include "common/slam/grid_slam_config.h"

namespace parloc {

inline const std::vector<Choice<SlamProposal>> kSlamProposals{{"motion", SlamProposal::motion},
                                                              {"scan_match", SlamProposal::scan_match},
                                                              {"gaussian", SlamProposal::gaussian}};

/// The group "slam"; the last three are those of SLAM. What is given outlives the table.
void add_slam_settings(Settings& s, SlamConfig& slam, int& max_beams, double& update_min_d,
                       double& update_min_a);
/// All that grid SLAM reads; the group "scan" has the same max_beams.
Settings settings_of(GridSlamConfig& config);

/// The first setting by name in which they differ, and how: "seed is 1 there and 2 here"; empty if there is
/// none. Where the work is done is not compared.
std::string config_difference(GridSlamConfig there, GridSlamConfig here);

}  // namespace parloc
