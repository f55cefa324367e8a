// Whoever asks for something while something is being done is served together with the others that wait.
#pragma once

#include <condition_variable>
#include <exception>
#include <mutex>
#include <vector>

namespace parloc {

/// Requests of many threads, done in batches of those that are alike. Nobody waits for others to ask: a batch
/// is whoever has come while the one before was being done, so that no thread can hold up another by staying
/// away. Thread-safe.
template <class Item>
class Gathering {
 public:
  using Items = std::vector<const Item*>;

  /// Has `work(items)` done for this item, on this thread or on that of another, and waits for it. The items
  /// of a batch are alike(first, each), in the order in which they came. Throws what the work threw, to
  /// everybody in the batch; it does nothing to those in others. Throws std::bad_alloc, and nothing has been
  /// asked for.
  template <class Alike, class Work>
  void ask(const Item& item, const Alike& alike, const Work& work) {
    Request mine{&item};
    std::unique_lock lock(mutex_);
    waiting_.push_back(&mine);
    while (!mine.done) {
      if (busy_) {
        changed_.wait(lock);
        continue;
      }
      try {
        taken_.reserve(waiting_.size());
        items_.reserve(waiting_.size());
      } catch (...) {
        std::erase(waiting_, &mine);
        changed_.notify_all();  // another takes over
        throw;
      }
      do_next(lock, alike, work);
    }
    if (mine.error) std::rethrow_exception(mine.error);
  }

  /// How many wait, beside those that are being done.
  std::size_t waiting() const {
    const std::lock_guard lock(mutex_);
    return waiting_.size();
  }

  /// work() while no batch is being done.
  template <class Work>
  void between(const Work& work) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !busy_; });
    work();
  }

 private:
  struct Request {
    const Item* item;
    bool done = false;
    std::exception_ptr error = {};
  };

  /// The oldest request that waits, with all that are like it.
  template <class Alike, class Work>
  void do_next(std::unique_lock<std::mutex>& lock, const Alike& alike, const Work& work) {
    busy_ = true;
    const Item& first = *waiting_.front()->item;
    std::size_t left = 0;
    for (Request* const request : waiting_)
      if (alike(first, *request->item))
        taken_.push_back(request), items_.push_back(request->item);
      else
        waiting_[left++] = request;
    waiting_.resize(left);
    lock.unlock();
    std::exception_ptr error;
    try {
      work(items_);
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    for (Request* const request : taken_) request->done = true, request->error = error;
    taken_.clear();
    items_.clear();
    busy_ = false;
    changed_.notify_all();
  }

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool busy_ = false;
  std::vector<Request*> waiting_, taken_;
  Items items_;
};

}  // namespace parloc
