// Numbers as bytes, little-endian on every machine, for files that parloc writes and reads itself.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <istream>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/math/sha256.h"

namespace parloc {

/// What has the same size on every machine.
template <class T>
concept FixedNumber = std::is_arithmetic_v<T> && !std::is_same_v<T, bool>;

/// Puts values one after the other into a sink, and knows the SHA-256 of all that it was given.
class ByteWriter {
 public:
  using Sink = std::function<void(const void* data, std::size_t size)>;
  explicit ByteWriter(Sink sink) : sink_(std::move(sink)) {}

  template <FixedNumber Number>
  void put(Number value) {
    put_all(&value, 1);
  }
  void put_bool(bool value) { put(static_cast<std::uint8_t>(value ? 1 : 0)); }
  void put_count(std::size_t count) { put(static_cast<std::uint64_t>(count)); }
  /// Their number, then all of them.
  void put_text(std::string_view text);
  template <FixedNumber Number>
  void put(const std::vector<Number>& values) {
    put_count(values.size());
    put_all(values.data(), values.size());
  }
  /// A count, then put_one(writer, item) for each.
  template <class Item, class PutOne>
  void put_each(const std::vector<Item>& items, const PutOne& put_one) {
    put_count(items.size());
    for (const Item& item : items) put_one(*this, item);
  }
  /// Without a count.
  template <FixedNumber Number>
  void put_all(const Number* values, std::size_t count) {
    if constexpr (std::endian::native == std::endian::little) {
      put_bytes(values, count * sizeof(Number));
    } else {
      for (std::size_t k = 0; k < count; ++k) {
        unsigned char bytes[sizeof(Number)];
        std::copy_n(reinterpret_cast<const unsigned char*>(values + k), sizeof(Number), bytes);
        std::reverse(bytes, bytes + sizeof(Number));
        put_bytes(bytes, sizeof(Number));
      }
    }
  }
  void put_bytes(const void* data, std::size_t size);

  /// Gives the sink what it has not got yet.
  void flush();
  /// Of all so far, in hexadecimal.
  std::string sha256();

 private:
  Sink sink_;
  Sha256 sha_;
  std::string pending_;
};

/// What `put` writes.
std::string bytes_of(const std::function<void(ByteWriter&)>& put);

/// Takes values out again. Every count is held against the bytes that are left, so that a file that lies
/// cannot ask for more memory than it has bytes. All member functions throw Error{input} naming the file.
class ByteReader {
 public:
  /// `size` bytes from where the stream stands. `name` stands for the file in messages.
  ByteReader(std::istream& in, std::uint64_t size, std::string name)
      : in_(in), left_(size), name_(std::move(name)) {}

  template <FixedNumber Number>
  Number get() {
    Number value{};
    get_all(&value, 1);
    return value;
  }
  bool get_bool();
  /// A count of items of at least `bytes_each`.
  std::size_t get_count(std::size_t bytes_each);
  std::string get_text();
  template <FixedNumber Number>
  std::vector<Number> get_vector() {
    std::vector<Number> values(get_count(sizeof(Number)));
    get_all(values.data(), values.size());
    return values;
  }
  /// get_one(reader) for each of the items that put_each wrote, of at least `bytes_each`.
  template <class GetOne>
  auto get_each(std::size_t bytes_each, const GetOne& get_one) {
    std::vector<std::invoke_result_t<GetOne, ByteReader&>> items(get_count(bytes_each));
    for (auto& item : items) item = get_one(*this);
    return items;
  }
  template <FixedNumber Number>
  void get_all(Number* values, std::size_t count) {
    get_bytes(values, count * sizeof(Number));
    if constexpr (std::endian::native != std::endian::little) {
      for (std::size_t k = 0; k < count; ++k) {
        auto* bytes = reinterpret_cast<unsigned char*>(values + k);
        std::reverse(bytes, bytes + sizeof(Number));
      }
    }
  }
  void get_bytes(void* to, std::size_t size);

  std::uint64_t left() const { return left_; }
  const std::string& name() const { return name_; }
  /// "name: damaged: expected `what`"
  void expect(bool holds, const char* what) const;

 private:
  std::istream& in_;
  std::uint64_t left_;
  std::string name_;
};

}  // namespace parloc
