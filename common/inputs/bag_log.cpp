#include "common/inputs/bag_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "common/bag/open_bag.h"
#include "common/error.h"
#include "common/inputs/robot_messages.h"

namespace parloc {

namespace {

constexpr std::size_t kMostMessages = 20;

MessageSources sources_of(const std::vector<TopicRole>& roles, const std::string& name) {
  const auto has = [&](TopicRole role) { return std::find(roles.begin(), roles.end(), role) != roles.end(); };
  return {name, has(TopicRole::odometry), has(TopicRole::transforms)};
}

class BagLog final : public LogReader {
 public:
  BagLog(const std::string& path, const LogChoice& choice)
      : name_(path),
        bag_(open_bag(path)),
        roles_(choose_topics(*bag_, choice, name_)),
        messages_(sources_of(roles_, name_), choice) {
    std::vector<bool> wanted;
    for (const TopicRole role : roles_) wanted.push_back(role != TopicRole::none);
    bag_->select(wanted);
  }

  bool next(LogRecord& record) override {
    while (!messages_.next(record)) {
      if (ended_ && messages_.placed() == 0) throw input_error(name_, 0, no_scans());
      if (ended_ && !any_scan_) throw input_error(name_, 0, messages_.joiner().why_none());
      if (ended_) return false;
      read_message();
    }
    if (record.kind == RecordKind::scan) count_scan(record);
    return true;
  }

  const LogWarnings& warnings() const override {
    const std::size_t seen =
        counted_.backward_stamps + counted_.beam_count_changes + bag_->faults().count + messages_.troubles();
    if (std::exchange(told_, seen) != seen) tell_all();
    return warnings_;
  }

  double progress() const override { return bag_->progress(); }

 private:
  void read_message();
  void tell_all() const;
  std::string no_scans() const;
  void count_scan(const LogRecord& record);

  std::string name_;
  std::unique_ptr<BagReader> bag_;
  std::vector<TopicRole> roles_;
  RobotMessages messages_;
  bool ended_ = false;
  LogWarnings counted_;
  mutable LogWarnings warnings_;  ///< What warnings() said last, and how many troubles that were.
  mutable std::size_t told_ = 0;
  std::map<std::string, std::size_t> beams_of_sensor_;
  double last_scan_stamp_s_ = 0.0;
  bool any_scan_ = false;
};

void BagLog::read_message() {
  BagMessage message;
  if (bag_->next(message)) {
    const BagTopic& topic = bag_->topics()[message.topic];
    messages_.take(roles_[message.topic], topic.name, topic.encoding, message.bytes);
  } else {
    ended_ = true;
    messages_.finish();
  }
}

void BagLog::tell_all() const {
  warnings_ = messages_.warnings();
  warnings_.backward_stamps = counted_.backward_stamps;
  warnings_.beam_count_changes = counted_.beam_count_changes;
  const BagFaults& faults = bag_->faults();
  warnings_.broken_lines += faults.count;
  for (const std::string& fault : faults.messages)
    if (warnings_.messages.size() < kMostMessages) warnings_.messages.push_back(fault);
}

std::string BagLog::no_scans() const {
  std::string topics;
  for (std::size_t k = 0; k < roles_.size(); ++k)
    if (roles_[k] == TopicRole::scan || roles_[k] == TopicRole::multi_echo_scan ||
        roles_[k] == TopicRole::cloud)
      topics += (topics.empty() ? "" : ", ") + printable(bag_->topics()[k].name);
  const std::vector<std::string>& said = warnings().messages;
  return fmt::format("expected at least one scan on {}, found none{}{}", topics, said.empty() ? "" : "; ",
                     said.empty() ? "" : said.front());
}

void BagLog::count_scan(const LogRecord& record) {
  if (any_scan_ && record.stamp_s < last_scan_stamp_s_) ++counted_.backward_stamps;
  any_scan_ = true;
  last_scan_stamp_s_ = record.stamp_s;
  std::size_t& beams = beams_of_sensor_[record.scan.sensor];
  if (beams != 0 && beams != record.scan.ranges_m.size()) ++counted_.beam_count_changes;
  beams = record.scan.ranges_m.size();
}

}  // namespace

std::unique_ptr<LogReader> open_bag_log(const std::string& path, const LogChoice& choice) {
  return std::make_unique<BagLog>(path, choice);
}

}  // namespace parloc
