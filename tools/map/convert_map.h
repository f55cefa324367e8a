// parloc map convert: grids to walls, walls to grids.
#pragma once

#include <string>

namespace parloc::tools {

/// As on the command line; empty: not given.
struct ConvertOptions {
  std::string in, out, to, resolution, max_error, picture;
  bool unknown_blocks = false;
};

/// Gives the exit code; throws Error.
int convert_map(const ConvertOptions& options);

}  // namespace parloc::tools
