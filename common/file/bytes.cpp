#include "common/file/bytes.h"

#include <fmt/format.h>

#include "common/error.h"

namespace parloc {
namespace {
constexpr std::size_t kFlushBytes = std::size_t{1} << 16;
}

void ByteWriter::put_bytes(const void* data, std::size_t size) {
  if (size == 0) return;
  if (pending_.size() + size > kFlushBytes) flush();
  if (size < kFlushBytes) {
    pending_.append(static_cast<const char*>(data), size);
    return;
  }
  sha_.add(data, size);
  sink_(data, size);
}

void ByteWriter::put_text(std::string_view text) {
  put_count(text.size());
  put_bytes(text.data(), text.size());
}

void ByteWriter::flush() {
  sha_.add(pending_.data(), pending_.size());
  sink_(pending_.data(), pending_.size());
  pending_.clear();
}

std::string ByteWriter::sha256() {
  flush();
  return sha_.hex();
}

std::string bytes_of(const std::function<void(ByteWriter&)>& put) {
  std::string bytes;
  ByteWriter w(
      [&](const void* data, std::size_t size) { bytes.append(static_cast<const char*>(data), size); });
  put(w);
  w.flush();
  return bytes;
}

void ByteReader::expect(bool holds, const char* what) const {
  if (!holds) throw input_error(name_, 0, fmt::format("damaged: expected {}", what));
}

void ByteReader::get_bytes(void* to, std::size_t size) {
  expect(size <= left_, "more bytes");
  if (size == 0) return;
  in_.read(static_cast<char*>(to), static_cast<std::streamsize>(size));
  if (static_cast<std::size_t>(in_.gcount()) != size) throw input_error(name_, 0, "cannot be read");
  left_ -= size;
}

bool ByteReader::get_bool() {
  const auto value = get<std::uint8_t>();
  expect(value <= 1, "a yes or no");
  return value == 1;
}

std::size_t ByteReader::get_count(std::size_t bytes_each) {
  const auto count = get<std::uint64_t>();
  expect(count <= left_ / bytes_each, "a count that the bytes are enough for");
  return static_cast<std::size_t>(count);
}

std::string ByteReader::get_text() {
  std::string text(get_count(1), '\0');
  get_bytes(text.data(), text.size());
  return text;
}

}  // namespace parloc
