// The filter's configuration as strict YAML.
#pragma once

#include <string>

#include "common/filter/config.h"

namespace parloc {

/// Reads a YAML file over `base`, which has the defaults unless given; a file that chooses `sensor.model`
/// starts from that model's defaults, wherever the key stands. Throws Error{config} with file:line for an
/// unknown key (naming the nearest valid one), a duplicate key, a wrong type, or a value out of its range
/// (naming the range). `alpha1..alpha4` require `form` beside them.
FilterConfig read_config(const std::string& path, const FilterConfig& base = {});
FilterConfig config_from_text(const std::string& text, const std::string& name,
                              const FilterConfig& base = {});

/// The whole configuration, every key with a comment that explains it. read_config gives it back.
std::string config_to_yaml(const FilterConfig& config);

/// The first setting by name in which they differ, and how: "seed is 1 there and 2 here"; empty if there is
/// none. Where the work is done (backend, threads, device) is not compared.
std::string config_difference(const FilterConfig& there, const FilterConfig& here);

/// Cross-field rules (mixture sums to 1 within 1e-6, ...). Throws Error{config} naming the key.
void validate(const FilterConfig& config);

}  // namespace parloc
