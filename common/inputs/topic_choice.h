// Which topics of a bag are a robot's log.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/bag/bag.h"
#include "common/inputs/topic_role.h"
#include "common/io/log_choice.h"

namespace parloc {

/// A topic that is looked for among those of some types.
struct TopicWish {
  std::string name;                ///< As the user says it; empty: the only one there is.
  std::string option;              ///< "--map-topic": how the user says it.
  std::string what;                ///< "a map", for people.
  std::vector<std::string> types;  ///< The first is named in messages.
  std::string otherwise{};         ///< What to do where there is none; may be empty.
};
/// Its index. Throws Error{input} naming the bag, with the choice there is: for none, for several with
/// messages, for a name that is not there (the nearest is named) or has another type.
std::size_t choose_topic(const BagReader& bag, const std::string& bag_name, const TopicWish& wish);

bool holds_transforms(const BagTopic& topic);
/// Of frames that do not move.
bool holds_fixed_transforms(const BagTopic& topic);

/// The role of each topic. Throws Error{input} naming the bag, with the choice there is: for no scans, for
/// several with messages where one must be chosen, for a topic that is not there (the nearest is named) or
/// has another type.
std::vector<TopicRole> choose_topics(const BagReader& bag, const LogChoice& choice,
                                     const std::string& bag_name);

/// "scan" for "/scan", "front/scan" for "/front/scan": a LiDAR by its topic.
std::string sensor_name(const std::string& topic);

}  // namespace parloc
