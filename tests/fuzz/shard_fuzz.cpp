// Any bytes are the results of a shard, or an Error{input} of one line: its head, its trials, and those of
// every command merged and put together. Tried as they are, and as the trials of a file whose head and
// checksums fit.
#include <sys/mman.h>
#include <unistd.h>
#include <zlib.h>

#include <functional>
#include <sstream>
#include <string>

#include "common/eval/trial_summary.h"
#include "common/file/bytes.h"
#include "tests/fuzz/one_line.h"
#include "tools/compare/run_bytes.h"
#include "tools/evaluate/families/drive_bytes.h"
#include "tools/shards/merged.h"
#include "tools/shards/shard_file.h"
#include "tools/shards/trial_bytes.h"

namespace {

using namespace parloc;
using namespace parloc::tools;

/// A file that is in memory alone.
class MemoryFile {
 public:
  explicit MemoryFile(const std::string& bytes) : descriptor_(memfd_create("shard", 0)) {
    fuzz::require(descriptor_ >= 0 &&
                  write(descriptor_, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()));
  }
  ~MemoryFile() { close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

void merge(const std::string& bytes) {
  const MemoryFile file(bytes);
  fuzz::reads_or_says_why(ErrorKind::input, [&] {
    const shards::Merged merged({file.path()});
    const ResultStream<TrialResult> results = merged.results<TrialResult>(shards::get_trial);
    (void)summarise(TrialPlan{}, 3.0, results);
  });
}

/// The bytes as so many trials, in a file that is as it should be.
std::string framed(const std::string& content, std::size_t items) {
  const shards::ShardHead head{"parloc evaluate", "1", "a", "", {{"map", "1"}}, items, {1, 1}};
  const std::string text = shards::text_of(head);
  return bytes_of([&](ByteWriter& w) {
    w.put_bytes("parloc shard\n", 13);
    w.put(std::uint32_t{1});
    w.put_text(text);
    for (std::size_t item = 0; item < items; ++item) {
      const std::size_t begin = content.size() * item / items, end = content.size() * (item + 1) / items;
      const std::string whole = bytes_of([&](ByteWriter& trial) {
        trial.put(std::uint64_t{item}), trial.put(0.5), trial.put(static_cast<std::uint32_t>(end - begin));
        trial.put_bytes(content.data() + begin, end - begin);
      });
      w.put(std::uint32_t{0x4c414954});
      w.put_bytes(whole.data(), whole.size());
      w.put(static_cast<std::uint32_t>(
          crc32(0, reinterpret_cast<const Bytef*>(whole.data()), static_cast<uInt>(whole.size()))));
    }
  });
}

void read_result(const std::string& bytes, const std::function<void(ByteReader&)>& get) {
  std::istringstream in(bytes);
  ByteReader reader(in, bytes.size(), "fuzz");
  fuzz::reads_or_says_why(ErrorKind::input, [&] { get(reader); });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes = fuzz::text_of(data, size);
  merge(bytes);
  merge(framed(bytes, 1));
  merge(framed(bytes, 2));
  read_result(bytes, [](ByteReader& r) { (void)families::get_drive(r); });
  read_result(bytes, [](ByteReader& r) { (void)compare::get_seed(r, 2); });
  return 0;
}
