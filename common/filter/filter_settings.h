// The tables of settings of filters, and the rules between them.
#pragma once

#include "common/filter/filter_config.h"
#include "common/settings/setting.h"

namespace parloc {

inline const std::vector<Choice<BackendChoice>> kBackends{
    {"auto", BackendChoice::automatic}, {"cpu", BackendChoice::cpu}, {"cuda", BackendChoice::cuda}};
inline const std::vector<Choice<ResampleScheme>> kResampleSchemes{
    {"systematic", ResampleScheme::systematic},
    {"stratified", ResampleScheme::stratified},
    {"residual", ResampleScheme::residual},
    {"multinomial", ResampleScheme::multinomial},
    {"multinomial_linear", ResampleScheme::multinomial_linear}};

/// Each adds settings whose values lie in the struct; that outlives the table.
void add_settings(Settings& s, ComputeConfig& compute);
void add_seed(Settings& s, std::uint64_t& seed);
void add_settings(Settings& s, ResampleConfig& resample);
/// The top level and every group of it, LiDARs included.
void add_settings(Settings& s, FilterConfig& config);

/// Rules of what all filters read.
std::optional<Violation> broken_rule(const StepConfig& config);
/// Rules of the particle filter, those of all filters among them.
std::optional<Violation> broken_rule(const FilterConfig& config);

}  // namespace parloc
