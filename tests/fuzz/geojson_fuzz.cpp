#include "tests/fuzz/segment_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  parloc::fuzz::check_segments(parloc::segment_map_from_geojson, parloc::fuzz::text_of(data, size));
  return 0;
}
