#include "common/bag/sqlite_bag.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <system_error>
#include <utility>

#include "common/bag/bytes/byte_stream.h"
#include "common/bag/bytes/decompress.h"
#include "common/bag/type_name.h"
#include "common/error.h"

namespace parloc {

namespace {

constexpr std::uint64_t kFewestBytesOfRow = 8;
constexpr int kStepsOfLook = 1000;              // of SQLite's machine, from look to look
constexpr std::uint64_t kMostStepsOfRow = 200;  // several queries look at every row
constexpr int kLongestRow = 65 << 20;

struct CloseDatabase {
  void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
};
struct Finalize {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Database = std::unique_ptr<sqlite3, CloseDatabase>;
using Statement = std::unique_ptr<sqlite3_stmt, Finalize>;

std::string_view blob_of(sqlite3_stmt* row, int column) {
  const void* bytes = sqlite3_column_blob(row, column);  // before its size, as SQLite wants it
  return bytes == nullptr ? std::string_view{}
                          : std::string_view(static_cast<const char*>(bytes),
                                             static_cast<std::size_t>(sqlite3_column_bytes(row, column)));
}

std::string text_of(sqlite3_stmt* row, int column) {
  const unsigned char* text = sqlite3_column_text(row, column);
  return text == nullptr ? "" : reinterpret_cast<const char*>(text);
}

class SqliteBag final : public BagReader {
 public:
  SqliteBag(const std::string& path, std::string name) : name_(std::move(name)) {
    open(path);
    read_topics();
    select(std::vector<bool>(topics_.size(), true));
  }

  const std::vector<BagTopic>& topics() const override { return topics_; }
  bool is_empty(std::size_t topic) const override;
  std::int64_t first_stamp_ns() const override;
  void select(const std::vector<bool>& topics) override;
  bool next(BagMessage& message) override;
  const BagFaults& faults() const override { return faults_; }
  double progress() const override {
    return most_id_ > 0 ? std::clamp(static_cast<double>(last_id_) / static_cast<double>(most_id_), 0.0, 1.0)
                        : 1.0;
  }
  std::string container() const override { return "sqlite3"; }

 private:
  void open(const std::string& path);
  static int is_too_long(void* bag) {
    auto* self = static_cast<SqliteBag*>(bag);
    self->steps_ += kStepsOfLook;
    return self->steps_ > self->most_rows_ * kMostStepsOfRow ? 1 : 0;
  }
  void read_topics();
  Statement prepare(const char* sql) const;
  bool next_id(std::int64_t& id);
  bool goes_on();
  bool end_in_circle();
  bool skip_hole();
  bool fetch(std::int64_t id, BagMessage& message);
  void count_unreadable(std::int64_t id, int code);
  void count_fault(const std::string& what);

  std::string name_;
  Database database_;
  std::vector<BagTopic> topics_;
  std::map<std::int64_t, std::size_t> topic_of_id_;
  std::vector<bool> wanted_;
  BagFaults faults_;
  Statement order_, row_;
  bool by_id_ = false;  ///< The order of the stamps cannot be had: the file is damaged.
  std::int64_t last_id_ = 0, last_stamp_ns_ = 0, most_id_ = 0;
  std::size_t unreadable_ = 0;
  std::uint64_t most_rows_ = 0, rows_ = 0, steps_ = 0;  ///< Since select().
  std::string unpacked_;
};

void SqliteBag::count_fault(const std::string& what) {
  ++faults_.count;
  if (faults_.messages.size() < 20) faults_.messages.push_back(fmt::format("{}: {}", name_, what));
}

void SqliteBag::open(const std::string& path) {
  sqlite3* database = nullptr;
  const int code =
      sqlite3_open_v2(path.c_str(), &database, SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX, nullptr);
  database_.reset(database);
  if (code != SQLITE_OK)
    throw input_error(name_, 0, fmt::format("cannot be opened: {}", sqlite3_errstr(code)));
  sqlite3_limit(database, SQLITE_LIMIT_LENGTH, kLongestRow);
  // The pages of a damaged file may go round in a circle: SQLite would follow them for years.
  std::error_code none;
  most_rows_ = std::filesystem::file_size(path, none) / kFewestBytesOfRow + 1000;
  sqlite3_progress_handler(database, kStepsOfLook, &SqliteBag::is_too_long, this);
  sqlite3_db_config(database, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  // Without the first, SQLite does not open a file that is shorter than it says.
  sqlite3_exec(database, "PRAGMA writable_schema=ON; PRAGMA cache_size=-8192; PRAGMA temp_store=FILE",
               nullptr, nullptr, nullptr);
}

Statement SqliteBag::prepare(const char* sql) const {
  sqlite3_stmt* statement = nullptr;
  sqlite3_prepare_v2(database_.get(), sql, -1, &statement, nullptr);
  return Statement(statement);
}

void SqliteBag::read_topics() {
  const Statement rows = prepare("SELECT id, name, type, serialization_format FROM topics ORDER BY id");
  const Statement messages = prepare("SELECT id, topic_id, timestamp, data FROM messages");
  if (rows == nullptr || messages == nullptr)
    throw input_error(name_, 0,
                      fmt::format("expected a ROS 2 bag with tables 'topics' and 'messages': {}",
                                  sqlite3_errmsg(database_.get())));
  int code = SQLITE_ROW;
  while ((code = sqlite3_step(rows.get())) == SQLITE_ROW) {
    topic_of_id_[sqlite3_column_int64(rows.get(), 0)] = topics_.size();
    topics_.push_back({text_of(rows.get(), 1), type_name(text_of(rows.get(), 2)), text_of(rows.get(), 3)});
  }
  if (code != SQLITE_DONE) count_fault(fmt::format("the table of topics: {}", sqlite3_errstr(code)));
  const Statement most = prepare("SELECT max(id) FROM messages");
  if (most != nullptr && sqlite3_step(most.get()) == SQLITE_ROW)
    most_id_ = sqlite3_column_int64(most.get(), 0);
}

bool SqliteBag::is_empty(std::size_t topic) const {
  const Statement any = prepare("SELECT 1 FROM messages WHERE topic_id = ? LIMIT 1");
  for (const auto& [id, index] : topic_of_id_) {
    if (index != topic) continue;
    sqlite3_reset(any.get());
    sqlite3_bind_int64(any.get(), 1, id);
    if (sqlite3_step(any.get()) != SQLITE_DONE) return false;
  }
  return true;
}

std::int64_t SqliteBag::first_stamp_ns() const {
  const Statement first = prepare("SELECT timestamp FROM messages ORDER BY timestamp LIMIT 1");
  const bool any = first != nullptr && sqlite3_step(first.get()) == SQLITE_ROW;
  return any ? sqlite3_column_int64(first.get(), 0) : std::numeric_limits<std::int64_t>::max();
}

void SqliteBag::select(const std::vector<bool>& topics) {
  wanted_ = topics;
  rows_ = steps_ = 0;
  last_id_ = 0;
  by_id_ = false;
  order_ = prepare("SELECT id, topic_id, timestamp FROM messages ORDER BY timestamp, id");
  row_ = prepare("SELECT data FROM messages WHERE id = ?");
}

// The next message's row. Where the file is damaged, rows come in the order in which they were written.
bool SqliteBag::next_id(std::int64_t& id) {
  for (;;) {
    int code = order_ == nullptr ? SQLITE_CORRUPT : sqlite3_step(order_.get());
    if (code == SQLITE_DONE) return false;
    if (code == SQLITE_ROW && goes_on()) {
      id = last_id_;
      return true;
    }
    const bool circle = code == SQLITE_ROW || code == SQLITE_INTERRUPT;
    if (circle && (by_id_ || code == SQLITE_INTERRUPT)) return end_in_circle();
    if (circle) code = SQLITE_CORRUPT;
    if (!by_id_) {
      count_fault(fmt::format("cut off or damaged ({}): what can be reached is read", sqlite3_errstr(code)));
      by_id_ = true;
      order_ = prepare("SELECT id, topic_id, timestamp FROM messages WHERE id > ?1 ORDER BY id");
      sqlite3_bind_int64(order_.get(), 1, last_id_);
      continue;
    }
    if (!skip_hole()) return false;
  }
}

// Whether the row comes after the one before it, as it was asked for. In a circle of pages it does not.
bool SqliteBag::goes_on() {
  const std::int64_t id = sqlite3_column_int64(order_.get(), 0);
  const std::int64_t stamp_ns = sqlite3_column_int64(order_.get(), 2);
  const bool first = rows_++ == 0;
  const bool later = by_id_ ? id > last_id_ : std::pair(stamp_ns, id) > std::pair(last_stamp_ns_, last_id_);
  if (!first && !later) return false;
  last_id_ = id;
  last_stamp_ns_ = stamp_ns;
  return true;
}

bool SqliteBag::end_in_circle() {
  count_fault("damaged: its pages go round in a circle; what was read before counts");
  order_.reset();
  row_.reset();
  return false;
}

// Behind pages that cannot be read: from the nearest row that can, by doubling steps.
bool SqliteBag::skip_hole() {
  if (order_ == nullptr) return false;
  for (std::int64_t step = 1; step < std::int64_t{1} << 40; step *= 2) {
    sqlite3_reset(order_.get());
    sqlite3_bind_int64(order_.get(), 1, last_id_ + step);
    const int code = sqlite3_step(order_.get());
    if (code == SQLITE_DONE) return false;
    if (code != SQLITE_ROW) continue;
    last_id_ += step;
    sqlite3_reset(order_.get());
    return true;
  }
  return false;
}

// The message of the row that next_id() found, if it is wanted and whole.
bool SqliteBag::fetch(std::int64_t id, BagMessage& message) {
  const auto topic = topic_of_id_.find(sqlite3_column_int64(order_.get(), 1));
  if (topic == topic_of_id_.end() || !wanted_[topic->second]) return false;  // before its data are looked for
  message.topic = topic->second;
  message.stamp_ns = sqlite3_column_int64(order_.get(), 2);
  sqlite3_reset(row_.get());
  sqlite3_bind_int64(row_.get(), 1, id);
  if (const int code = sqlite3_step(row_.get()); code != SQLITE_ROW) {
    count_unreadable(id, code);
    return false;
  }
  message.bytes = blob_of(row_.get(), 0);
  if (sqlite3_errcode(database_.get()) != SQLITE_ROW && message.bytes.empty()) return false;
  const std::size_t most = longest_message(topics_[message.topic]);
  try {
    if (is_zstd(message.bytes)) {
      unpack_zstd(message.bytes, most, unpacked_);
      message.bytes = unpacked_;
    }
    if (message.bytes.size() > most)
      throw Damage{fmt::format("{} bytes: expected at most {}", message.bytes.size(), most)};
  } catch (const Damage& damage) {
    count_fault(fmt::format("message {}: {}", id, damage.what));
    return false;
  }
  return true;
}

// Of a file that is cut off these are all messages from some place on: said once. By row numbers holes are
// expected.
void SqliteBag::count_unreadable(std::int64_t id, int code) {
  if (by_id_) return;
  if (++unreadable_ > 1) {
    ++faults_.count;
  } else {
    count_fault(
        fmt::format("cut off or damaged ({}): message {} and others are left out", sqlite3_errstr(code), id));
  }
}

bool SqliteBag::next(BagMessage& message) {
  for (std::int64_t id = 0; row_ != nullptr && next_id(id);)
    if (fetch(id, message)) return true;
  return false;
}

}  // namespace

std::unique_ptr<BagReader> open_sqlite_bag(const std::string& path, const std::string& name) {
  return std::make_unique<SqliteBag>(path, name);
}

}  // namespace parloc
