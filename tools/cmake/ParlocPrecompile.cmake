# Headers that nearly every source includes, read once per target. Off by default: with them a source that forgets
# an include compiles, and ccache has to be told to trust them.
set(_parloc_headers <algorithm> <cmath> <cstdint> <filesystem> <functional> <memory> <optional> <string> <utility> <vector>
  <fmt/format.h>)
target_precompile_headers(parloc PRIVATE ${_parloc_headers})
if(PARLOC_TOOLS)
  target_precompile_headers(parloc_tools PRIVATE ${_parloc_headers} <nlohmann/json.hpp>)
  target_precompile_headers(parloc_program PRIVATE ${_parloc_headers} <nlohmann/json.hpp> <CLI/CLI.hpp>)
endif()
