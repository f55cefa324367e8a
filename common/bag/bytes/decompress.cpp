#include "common/bag/bytes/decompress.h"

#include <bzlib.h>
#include <fmt/format.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <new>
#include <utility>
#include <vector>

#include "common/error.h"

namespace parloc {

namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 16;
constexpr int kLongestWindow_log2 = 26;  // 64 MiB

/// Keeps what a decompressor has not taken yet.
class Packed {
 public:
  explicit Packed(std::unique_ptr<ByteStream> stream) : stream_(std::move(stream)), block_(kBlockBytes) {}

  /// At least one byte, unless the stream is at its end.
  std::string_view get() {
    if (begin_ == end_) {
      begin_ = 0;
      end_ = stream_->read(block_.data(), block_.size());
    }
    return {block_.data() + begin_, end_ - begin_};
  }
  void take(std::size_t bytes) { begin_ += bytes; }

 private:
  std::unique_ptr<ByteStream> stream_;
  std::vector<char> block_;
  std::size_t begin_ = 0, end_ = 0;
};

/// What the three have in common: go on until the reader has what it wants.
class Unpacking : public ByteStream {
 public:
  explicit Unpacking(std::unique_ptr<ByteStream> packed) : packed_(std::move(packed)) {}

  std::size_t read(char* to, std::size_t size) final {
    std::size_t got = 0;
    while (got < size && !ended_) {
      const std::string_view in = packed_.get();
      const Step step = unpack(in, to + got, size - got);
      packed_.take(step.taken);
      got += step.given;
      if (step.given > 0 || step.taken > 0) continue;
      if (in.empty() && !between_frames_) throw Damage{"compressed data cut off"};
      if (!in.empty()) throw Damage{"damaged compressed data"};
      ended_ = true;
    }
    return got;
  }

 protected:
  struct Step {
    std::size_t taken, given;
  };
  /// Must do something if there is something to do. Throws Damage.
  virtual Step unpack(std::string_view in, char* to, std::size_t size) = 0;
  bool between_frames_ = false;  ///< Here the data may end.

 private:
  Packed packed_;
  bool ended_ = false;
};

struct FreeZstd {
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};
using ZstdContext = std::unique_ptr<ZSTD_DCtx, FreeZstd>;

/// The last one that was given back is taken again: its window is most of what a chunk would have to get from
/// the system anew.
thread_local ZstdContext spare_zstd;

ZstdContext zstd_context() {
  ZstdContext context = std::move(spare_zstd);
  if (context == nullptr) context.reset(ZSTD_createDCtx());
  if (context == nullptr) throw std::bad_alloc();
  ZSTD_DCtx_reset(context.get(), ZSTD_reset_session_only);
  ZSTD_DCtx_setParameter(context.get(), ZSTD_d_windowLogMax, kLongestWindow_log2);
  return context;
}

class ZstdStream final : public Unpacking {
 public:
  explicit ZstdStream(std::unique_ptr<ByteStream> packed)
      : Unpacking(std::move(packed)), context_(zstd_context()) {}
  ~ZstdStream() override { spare_zstd = std::move(context_); }

 private:
  Step unpack(std::string_view in, char* to, std::size_t size) override {
    ZSTD_inBuffer from{in.data(), in.size(), 0};
    ZSTD_outBuffer out{to, size, 0};
    const std::size_t left = ZSTD_decompressStream(context_.get(), &out, &from);
    if (ZSTD_isError(left) != 0) throw Damage{fmt::format("damaged zstd data: {}", ZSTD_getErrorName(left))};
    if (from.pos > 0 || out.pos > 0) between_frames_ = left == 0;
    return {from.pos, out.pos};
  }

  ZstdContext context_;
};

class Lz4Stream final : public Unpacking {
 public:
  explicit Lz4Stream(std::unique_ptr<ByteStream> packed) : Unpacking(std::move(packed)) {
    if (LZ4F_isError(LZ4F_createDecompressionContext(&context_, LZ4F_VERSION)) != 0) throw std::bad_alloc();
  }
  ~Lz4Stream() override { LZ4F_freeDecompressionContext(context_); }

 private:
  Step unpack(std::string_view in, char* to, std::size_t size) override {
    std::size_t taken = in.size(), given = size;
    const std::size_t hint = LZ4F_decompress(context_, to, &given, in.data(), &taken, nullptr);
    if (LZ4F_isError(hint) != 0) throw Damage{fmt::format("damaged lz4 data: {}", LZ4F_getErrorName(hint))};
    if (taken > 0 || given > 0) between_frames_ = hint == 0;
    return {taken, given};
  }

  LZ4F_dctx* context_ = nullptr;
};

class Bz2Stream final : public Unpacking {
 public:
  explicit Bz2Stream(std::unique_ptr<ByteStream> packed) : Unpacking(std::move(packed)) { start(); }
  ~Bz2Stream() override { BZ2_bzDecompressEnd(&state_); }

 private:
  void start() {
    state_ = {};
    if (BZ2_bzDecompressInit(&state_, 0, 0) != BZ_OK) throw std::bad_alloc();
  }

  Step unpack(std::string_view in, char* to, std::size_t size) override {
    if (in.empty()) return {0, 0};
    if (std::exchange(between_frames_, false)) {
      BZ2_bzDecompressEnd(&state_);
      start();
    }
    state_.next_in = const_cast<char*>(in.data());  // the library does not write to it
    state_.avail_in = static_cast<unsigned>(in.size());
    state_.next_out = to;
    state_.avail_out = static_cast<unsigned>(std::min(size, kBlockBytes));
    const unsigned room = state_.avail_out;
    const int result = BZ2_bzDecompress(&state_);
    if (result != BZ_OK && result != BZ_STREAM_END)
      throw Damage{fmt::format("damaged bz2 data: code {}", result)};
    between_frames_ = result == BZ_STREAM_END;
    return {in.size() - state_.avail_in, room - state_.avail_out};
  }

  bz_stream state_{};
};

}  // namespace

Compression compression_named(std::string_view name) {
  if (name.empty() || name == "none") return Compression::none;
  if (name == "zstd") return Compression::zstd;
  if (name == "lz4") return Compression::lz4;
  if (name == "bz2") return Compression::bz2;
  throw Damage{fmt::format("expected compression none, zstd, lz4 or bz2, found '{}'", printable(name))};
}

std::unique_ptr<ByteStream> decompressed(Compression compression, std::unique_ptr<ByteStream> packed) {
  switch (compression) {
    case Compression::none:
      return packed;
    case Compression::zstd:
      return std::make_unique<ZstdStream>(std::move(packed));
    case Compression::lz4:
      return std::make_unique<Lz4Stream>(std::move(packed));
    case Compression::bz2:
      return std::make_unique<Bz2Stream>(std::move(packed));
  }
  return packed;
}

bool is_zstd(std::string_view bytes) {
  return bytes.size() >= 4 && little_endian<std::uint32_t>(bytes.data()) == 0xFD2FB528u;
}

void unpack_zstd(std::string_view packed, std::size_t longest, std::string& to) {
  class Text final : public ByteStream {
   public:
    explicit Text(std::string_view text) : text_(text) {}
    std::size_t read(char* to, std::size_t size) override {
      const std::size_t part = std::min(size, text_.size());
      std::memcpy(to, text_.data(), part);
      text_.remove_prefix(part);
      return part;
    }

   private:
    std::string_view text_;
  };
  // The size that the frame states is the usual case, done at once; it may lie or be missing.
  const unsigned long long stated = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (stated <= std::min(longest, packed.size() * 64)) {
    to.resize(static_cast<std::size_t>(stated));
    const std::size_t got = ZSTD_decompress(to.data(), to.size(), packed.data(), packed.size());
    if (ZSTD_isError(got) == 0 && got == stated) return;
  }
  ZstdStream stream(std::make_unique<Text>(packed));
  to.clear();
  for (;;) {
    const std::size_t before = to.size();
    to.resize(before + kBlockBytes);
    const std::size_t got = stream.read(to.data() + before, kBlockBytes);
    to.resize(before + got);
    if (got < kBlockBytes) return;
    if (to.size() > longest) throw Damage{fmt::format("expected a message of at most {} bytes", longest)};
  }
}

}  // namespace parloc
