#include "tools/shards/shard.h"

#include <fmt/format.h>

#include "common/error.h"
#include "tools/program/parse_number.h"

namespace parloc::tools::shards {

Shard shard_from_text(const std::string& text) {
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos)
    throw Error(ErrorKind::usage,
                fmt::format("--shard: expected its number and how many there are, as 3/64, got '{}'",
                            printable(text)));
  Shard shard;
  shard.of = whole_within("--shard", text.substr(slash + 1), 1, Shard::kMost, 1);
  shard.number = whole_within("--shard", text.substr(0, slash), 1, shard.of, 1);
  return shard;
}

}  // namespace parloc::tools::shards
