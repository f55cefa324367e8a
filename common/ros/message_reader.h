// Takes the fields of a ROS message out of its bytes: CDR as ROS 2 writes it, or the packed form of ROS 1.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace parloc {

/// The bytes are not the message that they should be. Whoever reads the bag counts it.
struct BrokenMessage {
  std::string why;
};

/// Fields in the order of the message definition. All members throw BrokenMessage beyond the end. A count is
/// held against the bytes that are left, so that a message that lies cannot ask for more memory than it has.
class MessageReader {
 public:
  /// `encoding`: "cdr" (plain, XCDR 1 or 2, either byte order) or "ros1". Throws for any other.
  MessageReader(std::string_view bytes, std::string_view encoding);

  bool ros1() const { return ros1_; }

  template <class Number>
  Number number() {
    align(sizeof(Number));
    return swapped(take<Number>());
  }
  std::string text();
  /// The count of a sequence whose items have at least `bytes_each`.
  std::size_t count(std::size_t bytes_each);
  /// A sequence of numbers: count, then values.
  template <class Number>
  void numbers(std::vector<Number>& values) {
    values.resize(count(sizeof(Number)));
    if (values.empty()) return;
    align(sizeof(Number));
    need(values.size() * sizeof(Number));
    copy(values.data(), values.size() * sizeof(Number));
    if (swap_)
      for (Number& value : values) value = swapped(value);
  }
  /// The same, passed over.
  void skip_numbers(std::size_t bytes_each);
  /// A sequence of bytes as they lie.
  std::string_view octets();

 private:
  template <class Number>
  Number take() {
    need(sizeof(Number));
    Number value;
    copy(&value, sizeof(Number));
    return value;
  }
  template <class Number>
  Number swapped(Number value) const {
    if (!swap_) return value;
    unsigned char bytes[sizeof(Number)], turned[sizeof(Number)];
    __builtin_memcpy(bytes, &value, sizeof(Number));
    for (std::size_t k = 0; k < sizeof(Number); ++k) turned[k] = bytes[sizeof(Number) - 1 - k];
    __builtin_memcpy(&value, turned, sizeof(Number));
    return value;
  }
  void align(std::size_t size);
  void need(std::size_t size) const;
  void copy(void* to, std::size_t size);

  std::string_view bytes_;
  std::size_t at_ = 0;
  bool ros1_ = false, swap_ = false;
  std::size_t longest_alignment_ = 8;
};

}  // namespace parloc
