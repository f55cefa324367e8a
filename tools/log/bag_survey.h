// What is in a bag, topic by topic, and which of it a log would be read from.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/bag/bag.h"
#include "common/io/log_choice.h"
#include "tools/log/stamp_survey.h"

namespace parloc::tools {

struct TopicSurvey {
  BagTopic topic;
  StampSurvey recorded;  ///< When messages were recorded.
  std::uint64_t bytes = 0;
};

struct BagSurvey {
  std::string container;
  std::vector<TopicSurvey> topics;
  BagFaults faults;

  std::size_t messages() const;
  /// Those of the type that have messages.
  std::vector<const TopicSurvey*> of_type(const std::string& type) const;
};

/// Reads all messages, without looking into them.
BagSurvey survey_bag(BagReader& bag, const std::function<void(double)>& progress,
                     const std::function<bool()>& stop);

/// What a person who knows no better would choose where the choice leaves several, and the options that say
/// so.
struct SuggestedChoice {
  LogChoice choice;
  std::vector<std::string> options;  ///< "--scan-topic /scan"
  std::vector<std::string> reasons;  ///< One line for each.
  std::string map_topic;             ///< Empty: the bag has no map.
  bool no_odometry = false;          ///< Neither a topic of it nor transforms.
};
SuggestedChoice suggest_choice(const BagSurvey& bag, const LogChoice& given);

}  // namespace parloc::tools
