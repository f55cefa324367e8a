// What was learned, as a picture: how far measured ranges lie from expected ones, and the fitted mixture.
#pragma once

#include <string>

#include "common/eval/fit_mixture.h"

namespace parloc::tools {

/// One PNG: density over measured minus expected range, logarithmic, of the beams that hit something where
/// the map has a wall in reach: as measured, and as the mixture says for the same expected ranges. Throws
/// Error{output}.
void write_mixture_picture(const std::string& path, const RangePairs& ranges, const Mixture& mixture);

}  // namespace parloc::tools
