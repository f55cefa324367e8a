#include "common/bag/bag_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <system_error>
#include <utility>
#include <vector>

#include "common/bag/open_bag.h"
#include "common/error.h"
#include "common/file/yaml_reader.h"

namespace parloc {

namespace {

namespace fs = std::filesystem;

constexpr YamlRules kMetadataRules{"metadata of a bag", std::size_t{4} << 20, ErrorKind::input, true};

/// Bags one after the other; a topic of the same name and type is the same topic.
class SplitBag final : public BagReader {
 public:
  explicit SplitBag(BagFaults faults) : own_(std::move(faults)) {}

  void add(std::unique_ptr<BagReader> bag) {
    std::vector<std::size_t> of_bag;
    for (const BagTopic& topic : bag->topics()) {
      const auto same = [&](const BagTopic& t) {
        return t.name == topic.name && t.type == topic.type && t.encoding == topic.encoding;
      };
      const auto known = std::find_if(topics_.begin(), topics_.end(), same);
      of_bag.push_back(static_cast<std::size_t>(known - topics_.begin()));
      if (known == topics_.end()) topics_.push_back(topic);
    }
    parts_.push_back({std::move(bag), std::move(of_bag)});
  }

  const std::vector<BagTopic>& topics() const override { return topics_; }

  bool is_empty(std::size_t topic) const override {
    for (const Part& part : parts_)
      for (std::size_t k = 0; k < part.topic.size(); ++k)
        if (part.topic[k] == topic && !part.bag->is_empty(k)) return false;
    return true;
  }

  std::int64_t first_stamp_ns() const override {
    std::int64_t first_ns = std::numeric_limits<std::int64_t>::max();
    for (const Part& part : parts_) first_ns = std::min(first_ns, part.bag->first_stamp_ns());
    return first_ns;
  }

  void select(const std::vector<bool>& topics) override {
    for (const Part& part : parts_) {
      std::vector<bool> wanted;
      for (const std::size_t topic : part.topic) wanted.push_back(topics[topic]);
      part.bag->select(wanted);
    }
    at_ = 0;
  }

  bool next(BagMessage& message) override {
    for (; at_ < parts_.size(); ++at_) {
      if (!parts_[at_].bag->next(message)) continue;
      message.topic = parts_[at_].topic[message.topic];
      return true;
    }
    return false;
  }

  const BagFaults& faults() const override {
    faults_ = own_;
    for (const Part& part : parts_) {
      const BagFaults& more = part.bag->faults();
      faults_.count += more.count;
      faults_.messages.insert(faults_.messages.end(), more.messages.begin(), more.messages.end());
    }
    return faults_;
  }

  double progress() const override {
    if (at_ >= parts_.size()) return 1.0;
    return (static_cast<double>(at_) + parts_[at_].bag->progress()) / static_cast<double>(parts_.size());
  }

  std::string container() const override { return parts_.front().bag->container(); }

 private:
  struct Part {
    std::unique_ptr<BagReader> bag;
    std::vector<std::size_t> topic;  ///< Of each topic of the bag: index into topics_.
  };
  std::vector<Part> parts_;
  std::vector<BagTopic> topics_;
  std::size_t at_ = 0;
  BagFaults own_;
  mutable BagFaults faults_;
};

const YamlNode* find(const YamlNode& group, const std::string& key) {
  for (const YamlNode& node : group.items)
    if (node.key == key) return &node;
  return nullptr;
}

std::vector<std::string> listed_files(const fs::path& metadata) {
  const YamlNode root =
      yaml_tree(read_yaml_file(metadata.string(), kMetadataRules), metadata.string(), kMetadataRules);
  const YamlNode* bag = find(root, "rosbag2_bagfile_information");
  const YamlNode* paths = bag == nullptr ? nullptr : find(*bag, "relative_file_paths");
  std::vector<std::string> files;
  if (paths != nullptr)
    for (const YamlNode& path : paths->items) files.push_back(path.text);
  if (files.empty())
    throw input_error(metadata.string(), 0, "expected rosbag2_bagfile_information with relative_file_paths");
  return files;
}

/// Older versions write the path from where they were started; compressed files may be listed without
/// ".zstd".
fs::path file_in(const fs::path& folder, const std::string& listed) {
  const fs::path name = fs::path(listed).filename();
  for (const fs::path& path : {folder / name, folder / (name.string() + ".zstd")})
    if (fs::exists(path)) return path;
  return folder / name;
}

std::vector<fs::path> bags_in(const fs::path& folder) {
  std::vector<fs::path> bags;
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(folder, failed))
    if (entry.is_regular_file() && is_bag(entry.path().string())) bags.push_back(entry.path());
  std::sort(bags.begin(), bags.end());
  return bags;
}

void note(BagFaults& faults, std::string what) {
  ++faults.count;
  faults.messages.push_back(std::move(what));
}

}  // namespace

std::unique_ptr<BagReader> open_bag_folder(const std::string& path) {
  const fs::path folder(path);
  std::vector<fs::path> files;
  BagFaults faults;
  const fs::path metadata = folder / "metadata.yaml";
  if (fs::exists(metadata)) {
    try {
      for (const std::string& listed : listed_files(metadata)) files.push_back(file_in(folder, listed));
    } catch (const Error& error) {
      note(faults, fmt::format("{}; all bags of the folder are read", error.what()));
    }
  }
  const bool listed = !files.empty();
  if (!listed) files = bags_in(folder);
  if (files.empty())
    throw input_error(path, 0, "expected a bag, found a folder without any (no .db3, .mcap or .bag in it)");
  std::vector<std::unique_ptr<BagReader>> bags;
  std::string first_error;
  for (const fs::path& file : files) {
    try {
      if (fs::is_directory(file)) throw input_error(file.string(), 0, "expected a file, found a folder");
      bags.push_back(open_bag(file.string()));
    } catch (const Error& error) {
      if (first_error.empty()) first_error = error.what();
      note(faults, error.what());
    }
  }
  if (bags.empty()) throw Error(ErrorKind::input, first_error);
  if (!listed)
    std::stable_sort(bags.begin(), bags.end(),
                     [](const auto& a, const auto& b) { return a->first_stamp_ns() < b->first_stamp_ns(); });
  auto all = std::make_unique<SplitBag>(std::move(faults));
  for (auto& bag : bags) all->add(std::move(bag));
  all->select(std::vector<bool>(all->topics().size(), true));
  return all;
}

std::unique_ptr<BagReader> with_fault(std::unique_ptr<BagReader> bag, const std::string& what) {
  auto one = std::make_unique<SplitBag>(BagFaults{1, {what}});
  one->add(std::move(bag));
  one->select(std::vector<bool>(one->topics().size(), true));
  return one;
}

}  // namespace parloc
