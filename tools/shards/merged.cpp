#include "tools/shards/merged.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <iterator>
#include <sstream>
#include <utility>

#include "common/error.h"

namespace parloc::tools::shards {
namespace {

constexpr std::size_t kListed = 20;  // of a message
constexpr std::size_t kMostOpen = 200;

/// "3, 17, 20 and 5 more".
std::string listed(const std::vector<std::size_t>& numbers) {
  std::string text;
  for (std::size_t k = 0; k < numbers.size() && k < kListed; ++k)
    fmt::format_to(std::back_inserter(text), "{}{}", k > 0 ? ", " : "", numbers[k]);
  if (numbers.size() > kListed)
    fmt::format_to(std::back_inserter(text), " and {} more", numbers.size() - kListed);
  return text;
}

/// Files that are read here and there, of which only so many may be open at once.
class OpenFiles {
 public:
  explicit OpenFiles(const std::vector<std::string>& paths) : paths_(paths), descriptors_(paths.size(), -1) {}
  ~OpenFiles() {
    for (const int descriptor : descriptors_)
      if (descriptor >= 0) close(descriptor);
  }
  OpenFiles(const OpenFiles&) = delete;
  OpenFiles& operator=(const OpenFiles&) = delete;

  void read(std::size_t file, std::uint64_t offset, std::string& bytes) {
    int descriptor = descriptors_[file];
    if (descriptor < 0) descriptor = open(paths_[file].c_str(), O_RDONLY | O_CLOEXEC);
    const ssize_t got =
        descriptor < 0 ? -1 : pread(descriptor, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (descriptor >= 0 && file >= kMostOpen)
      close(descriptor);
    else
      descriptors_[file] = descriptor;
    if (got != static_cast<ssize_t>(bytes.size())) throw input_error(paths_[file], 0, "cannot be read");
  }

 private:
  const std::vector<std::string>& paths_;
  std::vector<int> descriptors_;
};

}  // namespace

Merged::Merged(const std::vector<std::string>& folders) {
  for (const std::string& folder : folders) paths_.push_back(shard_path(folder));
  for (const std::string& path : paths_) {
    contents_.push_back(read_shard(path));
    if (contents_.size() == 1) places_.resize(head().items, {0, 0, 0});
    const std::string why = difference(head(), paths_.front(), contents_.back().head, path);
    if (!why.empty()) throw Error(ErrorKind::input, "expected shards of one run: " + why);
    find_trials();
  }
  check_shards();
}

/// Of the shard that was read last.
void Merged::find_trials() {
  ShardContents& c = contents_.back();
  const auto shard = static_cast<std::uint32_t>(contents_.size() - 1);
  const std::string& path = paths_[shard];
  for (std::size_t other = 0; other < shard; ++other)
    if (contents_[other].head.shard.number == c.head.shard.number)
      throw Error(ErrorKind::input, fmt::format("{} and {} are the same shard, {} of {}: expected each once",
                                                paths_[other], path, c.head.shard.number, c.head.shard.of));
  if (c.damaged)
    throw input_error(path, 0,
                      fmt::format("damaged after {} trials: run that shard again, which goes on from there",
                                  c.trials.size()));
  const std::size_t of_shard = c.head.shard.items(c.head.items).size();
  std::size_t found = 0;
  for (const StoredTrial& trial : c.trials) {
    Place& place = places_[trial.item];
    found += place.offset == 0 ? 1 : 0;
    place = {shard, trial.size, trial.offset};
    took_s_ += trial.took_s;
  }
  if (found < of_shard)
    throw input_error(
        path, 0,
        fmt::format("shard {} of {} has {} of its {} trials: run it again, which goes on from there",
                    c.head.shard.number, c.head.shard.of, found, of_shard));
  c.trials = {};
}

void Merged::check_shards() const {
  std::vector<bool> there(head().shard.of, false);
  for (const ShardContents& c : contents_) there[c.head.shard.number - 1] = true;
  std::vector<std::size_t> missing;
  for (std::size_t k = 0; k < there.size(); ++k)
    if (!there[k] && !Shard{k + 1, there.size()}.items(head().items).empty()) missing.push_back(k + 1);
  if (!missing.empty())
    throw Error(ErrorKind::input, fmt::format("expected all {} shards, found {}: missing {}", there.size(),
                                              contents_.size(), listed(missing)));
}

void Merged::check(const ShardHead& here) const {
  const std::string why = difference(head(), paths_.front(), here, "what is here");
  if (!why.empty()) throw Error(ErrorKind::input, "expected what the shards were made of: " + why);
}

void Merged::each(const std::function<void(ByteReader&)>& take) const {
  OpenFiles files(paths_);
  std::string bytes;
  for (const Place& place : places_) {
    bytes.resize(place.size);
    files.read(place.shard, place.offset, bytes);
    std::istringstream in(bytes);
    ByteReader reader(in, bytes.size(), paths_[place.shard]);
    take(reader);
    reader.expect(reader.left() == 0, "a trial's end");
  }
}

}  // namespace parloc::tools::shards
