// Bytes of a file that come one after the other, and the file that they are in.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>

namespace parloc {

/// Bytes are not what they should be: what was expected. Readers of bags count it and go on with what is
/// whole; it reaches no user as it is.
struct Damage {
  std::string what;
  bool all = false;  ///< Nothing of the chunk can be trusted, not even what came before.
};

/// A little-endian number at `from`.
template <class Number>
Number little_endian(const char* from) {
  unsigned char bytes[sizeof(Number)];
  std::memcpy(bytes, from, sizeof(Number));
  Number value = 0;
  for (std::size_t k = sizeof(Number); k-- > 0;) value = static_cast<Number>(value << 8 | bytes[k]);
  return value;
}
template <>
inline std::uint8_t little_endian<std::uint8_t>(const char* from) {
  return static_cast<std::uint8_t>(*from);
}

class ByteStream {
 public:
  virtual ~ByteStream() = default;
  /// Up to `size` bytes, fewer only at the end. Throws Damage.
  virtual std::size_t read(char* to, std::size_t size) = 0;
  /// As if read and thrown away.
  virtual void skip(std::uint64_t size);

  /// Throws Damage if there are fewer.
  void read_all(char* to, std::size_t size);
  /// Appends `size` bytes to `to`. A length that lies costs no more memory than there are bytes.
  void append_to(std::string& to, std::uint64_t size);
  template <class Number>
  Number number() {
    char bytes[sizeof(Number)];
    read_all(bytes, sizeof(Number));
    return little_endian<Number>(bytes);
  }
};

/// A file that is read here and there.
class BagFile {
 public:
  /// Throws Error{input} if it cannot be opened or is no file.
  explicit BagFile(const std::string& path);
  /// Takes over an open file; `path` stands for it in messages.
  BagFile(int descriptor, std::string path);
  ~BagFile();
  BagFile(const BagFile&) = delete;
  BagFile& operator=(const BagFile&) = delete;

  const std::string& path() const { return path_; }
  std::uint64_t size() const { return size_; }
  /// Up to `size` bytes from there, fewer only at the end. Throws Damage.
  std::size_t read_at(std::uint64_t offset, char* to, std::size_t size) const;
  /// At most `size` bytes from there, as a stream. The file must outlive it.
  std::unique_ptr<ByteStream> stream(std::uint64_t offset, std::uint64_t size) const;

 private:
  int descriptor_;
  std::string path_;
  std::uint64_t size_ = 0;
};

}  // namespace parloc
