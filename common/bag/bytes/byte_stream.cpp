#include "common/bag/bytes/byte_stream.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>
#include <vector>

#include "common/error.h"

namespace parloc {

namespace {

// Blocks grow while bytes are read in a row: who only looks at heads reads little.
constexpr std::size_t kFirstBlock = std::size_t{1} << 12;
constexpr std::size_t kLongestBlock = std::size_t{1} << 18;

/// A part of a file, through a buffer.
class FileStream final : public ByteStream {
 public:
  FileStream(const BagFile& file, std::uint64_t offset, std::uint64_t size)
      : file_(file),
        next_(offset),
        end_(offset + std::min(size, file.size() - std::min(offset, file.size()))) {}

  std::size_t read(char* to, std::size_t size) override {
    std::size_t got = 0;
    while (got < size) {
      if (begin_ == buffer_.size() && !refill()) break;
      const std::size_t part = std::min(size - got, buffer_.size() - begin_);
      std::memcpy(to + got, buffer_.data() + begin_, part);
      begin_ += part;
      got += part;
    }
    return got;
  }

  void skip(std::uint64_t size) override {
    const std::uint64_t buffered = buffer_.size() - begin_;
    if (size <= buffered) {
      begin_ += static_cast<std::size_t>(size);
      return;
    }
    begin_ = buffer_.size();
    if (size - buffered > end_ - next_) throw Damage{"cut off"};
    next_ += size - buffered;
    block_ = kFirstBlock;
  }

 private:
  bool refill() {
    buffer_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(block_, end_ - next_)));
    begin_ = 0;
    block_ = std::min(block_ * 2, kLongestBlock);
    buffer_.resize(file_.read_at(next_, buffer_.data(), buffer_.size()));
    next_ += buffer_.size();
    return !buffer_.empty();
  }

  const BagFile& file_;
  std::uint64_t next_, end_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;
  std::size_t block_ = kFirstBlock;
};

}  // namespace

void ByteStream::skip(std::uint64_t size) {
  char scratch[4096];
  while (size > 0) {
    const auto part = static_cast<std::size_t>(std::min<std::uint64_t>(size, sizeof scratch));
    read_all(scratch, part);
    size -= part;
  }
}

void ByteStream::read_all(char* to, std::size_t size) {
  if (read(to, size) != size) throw Damage{"cut off"};
}

void ByteStream::append_to(std::string& to, std::uint64_t size) {
  constexpr std::uint64_t step = std::uint64_t{1} << 20;
  while (size > 0) {
    const auto part = static_cast<std::size_t>(std::min(size, step));
    const std::size_t before = to.size();
    to.resize(before + part);
    read_all(to.data() + before, part);
    size -= part;
  }
}

BagFile::BagFile(const std::string& path) : BagFile(::open(path.c_str(), O_RDONLY | O_CLOEXEC), path) {}

BagFile::BagFile(int descriptor, std::string path) : descriptor_(descriptor), path_(std::move(path)) {
  if (descriptor_ < 0) throw input_error(path_, 0, std::string("cannot be opened: ") + std::strerror(errno));
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(descriptor_);
    throw input_error(path_, 0, "cannot be read: expected a file");
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
}

BagFile::~BagFile() {
  ::close(descriptor_);
}

std::size_t BagFile::read_at(std::uint64_t offset, char* to, std::size_t size) const {
  std::size_t got = 0;
  while (got < size) {
    const ssize_t part = ::pread(descriptor_, to + got, size - got, static_cast<off_t>(offset + got));
    if (part < 0 && errno == EINTR) continue;
    if (part < 0) throw Damage{fmt::format("cannot be read: {}", std::strerror(errno))};
    if (part == 0) break;
    got += static_cast<std::size_t>(part);
  }
  return got;
}

std::unique_ptr<ByteStream> BagFile::stream(std::uint64_t offset, std::uint64_t size) const {
  return std::make_unique<FileStream>(*this, offset, size);
}

}  // namespace parloc
