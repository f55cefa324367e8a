#include "common/ros/message_reader.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/error.h"

namespace parloc {

MessageReader::MessageReader(std::string_view bytes, std::string_view encoding) : bytes_(bytes) {
  constexpr bool little = std::endian::native == std::endian::little;
  if (encoding == "ros1") {
    ros1_ = true;
    swap_ = !little;
    longest_alignment_ = 1;
    return;
  }
  if (encoding != "cdr")
    throw BrokenMessage{fmt::format("expected encoding cdr or ros1, found '{}'", printable(encoding))};
  if (bytes.size() < 4) throw BrokenMessage{"expected the four bytes before a CDR message"};
  // The second byte is the representation: 0 and 1 plain CDR, 6 and 7 plain CDR of XCDR 2, whose numbers of
  // 8 bytes stand at multiples of 4; odd ones are little-endian.
  const int kind = static_cast<unsigned char>(bytes[1]);
  if (bytes[0] != 0 || (kind != 0 && kind != 1 && kind != 6 && kind != 7))
    throw BrokenMessage{fmt::format("expected plain CDR, found representation {}", kind)};
  swap_ = (kind % 2 == 1) != little;
  if (kind >= 6) longest_alignment_ = 4;
  bytes_.remove_prefix(4);
}

void MessageReader::align(std::size_t size) {
  const std::size_t to = std::min(size, longest_alignment_);
  at_ = (at_ + to - 1) / to * to;
}

void MessageReader::need(std::size_t size) const {
  if (at_ > bytes_.size() || size > bytes_.size() - at_)
    throw BrokenMessage{fmt::format("expected a longer message, found {} bytes", bytes_.size())};
}

void MessageReader::copy(void* to, std::size_t size) {
  __builtin_memcpy(to, bytes_.data() + at_, size);
  at_ += size;
}

std::size_t MessageReader::count(std::size_t bytes_each) {
  const std::size_t count = number<std::uint32_t>();
  const std::size_t left = bytes_.size() - std::min(at_, bytes_.size());
  if (count > left / std::max<std::size_t>(bytes_each, 1))
    throw BrokenMessage{fmt::format("expected a count, found {}, more than the message holds", count)};
  return count;
}

std::string MessageReader::text() {
  std::string_view text = octets();
  if (!ros1_ && !text.empty() && text.back() == '\0') text.remove_suffix(1);
  return std::string(text);
}

void MessageReader::skip_numbers(std::size_t bytes_each) {
  const std::size_t size = count(bytes_each) * bytes_each;
  if (size == 0) return;
  align(bytes_each);
  need(size);
  at_ += size;
}

std::string_view MessageReader::octets() {
  const std::size_t size = count(1);
  const std::string_view octets = bytes_.substr(at_, size);
  at_ += size;
  return octets;
}

}  // namespace parloc
