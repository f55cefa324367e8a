#include "tests/fuzz/segment_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  parloc::fuzz::check_segments(parloc::segment_map_from_geojson, text);
  return 0;
}
