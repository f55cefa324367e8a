// Many pieces of work in a few threads, which can be stopped.
#pragma once

#include <cstddef>
#include <functional>

namespace parloc::tools {

struct ItemsRequest {
  std::size_t items = 0;
  int threads = 1;
  std::function<bool()> stop;  ///< Asked often, on the caller's thread; may be empty.
  std::function<void()> tell;  ///< Called as often; may be empty.
};

/// Whether to go on: false once `stop` said so, or after an error in another thread.
using KeepGoing = std::function<bool()>;
/// Does one item. Only one thread calls it, so that it may have things of its own.
using Worker = std::function<void(std::size_t item)>;

/// Calls `make_worker` once in each thread, and the workers with the items from 0 on as they get free. The
/// first error ends the work and is thrown.
void run_items(const ItemsRequest& request,
               const std::function<Worker(std::size_t thread, const KeepGoing& keep_going)>& make_worker);

}  // namespace parloc::tools
