// Stands for the writer of MCAP in a build without zstd.
#include "common/error.h"
#include "common/mcap/mcap_writer.h"

namespace parloc {

struct McapWriter::State {};

McapWriter::McapWriter(Sink, double) {
  throw Error(
      ErrorKind::output,
      "this parloc writes no MCAP: it was built without SQLite, zstd, lz4 or bzip2 (docs/building.md)");
}
McapWriter::~McapWriter() = default;
std::uint16_t McapWriter::add_topic(const McapTopic&) {
  return 0;
}
void McapWriter::write(std::uint16_t, std::int64_t, std::string_view) {}
void McapWriter::finish() {}

}  // namespace parloc
