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
constexpr std::size_t kMostOpen = 200, kNone = static_cast<std::size_t>(-1);

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
    ShardContents contents = read_shard(path);
    if (places_.empty()) head_ = contents.head;
    const std::string why = difference(head(), paths_.front(), contents.head, path);
    if (!why.empty()) throw Error(ErrorKind::input, "expected shards of one run: " + why);
    find_trials(std::move(contents), path);
  }
  check_shards();
}

/// Nothing here is larger than what the file has of trials, whatever its head says.
void Merged::find_trials(ShardContents c, const std::string& path) {
  const std::size_t file = places_.size();
  const Shard& shard = c.head.shard;
  file_of_.resize(shard.of, kNone);
  std::size_t& place_of_shard = file_of_[shard.number - 1];
  if (place_of_shard != kNone)
    throw Error(ErrorKind::input, fmt::format("{} and {} are the same shard, {} of {}: expected each once",
                                              paths_[place_of_shard], path, shard.number, shard.of));
  place_of_shard = file;
  if (c.damaged)
    throw input_error(path, 0,
                      fmt::format("damaged after {} trials: run that shard again, which goes on from there",
                                  c.trials.size()));
  const auto by_item = [](const StoredTrial& a, const StoredTrial& b) { return a.item < b.item; };
  const auto same = [](const StoredTrial& a, const StoredTrial& b) { return a.item == b.item; };
  std::stable_sort(c.trials.begin(), c.trials.end(), by_item);
  c.trials.erase(std::unique(c.trials.begin(), c.trials.end(), same), c.trials.end());
  const std::size_t count = shard.count(c.head.items);
  if (c.trials.size() < count)
    throw input_error(
        path, 0,
        fmt::format("shard {} of {} has {} of its {} trials: run it again, which goes on from there",
                    shard.number, shard.of, c.trials.size(), count));
  std::vector<Place>& places = places_.emplace_back();
  places.reserve(count);
  for (const StoredTrial& trial : c.trials) {
    places.push_back({trial.offset, trial.size});
    took_s_ += trial.took_s;
  }
}

void Merged::check_shards() const {
  std::vector<std::size_t> missing;
  for (std::size_t k = 0; k < file_of_.size(); ++k)
    if (file_of_[k] == kNone && Shard{k + 1, file_of_.size()}.count(head().items) > 0)
      missing.push_back(k + 1);
  if (!missing.empty())
    throw Error(ErrorKind::input, fmt::format("expected all {} shards, found {}: missing {}", file_of_.size(),
                                              shards(), listed(missing)));
}

void Merged::check(const ShardHead& here) const {
  const std::string why = difference(head(), paths_.front(), here, "what is here");
  if (!why.empty()) throw Error(ErrorKind::input, "expected what the shards were made of: " + why);
}

void Merged::each(const std::function<void(ByteReader&)>& take) const {
  OpenFiles files(paths_);
  std::string bytes;
  const std::size_t of = file_of_.size();
  for (std::size_t item = 0; item < head().items; ++item) {
    const std::size_t file = file_of_[item % of];
    const Place& place = places_[file][item / of];
    bytes.resize(place.size);
    files.read(file, place.offset, bytes);
    std::istringstream in(bytes);
    ByteReader reader(in, bytes.size(), paths_[file]);
    take(reader);
    reader.expect(reader.left() == 0, "a trial's end");
  }
}

}  // namespace parloc::tools::shards
