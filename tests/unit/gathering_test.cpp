#include "cuda/gathering.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

namespace parloc {
namespace {

struct Job {
  int kind = 0;
  int number = 0;
};
using Jobs = Gathering<Job>::Items;

bool alike(const Job& a, const Job& b) {
  return a.kind == b.kind;
}

/// Does work in batches, and writes down which.
class Shop {
 public:
  std::function<void(const Jobs&)> also;  // in each batch
  std::vector<std::string> batches;       // written by one batch at a time

  /// Whether it went well.
  bool ask(int kind, int number) {
    try {
      gathering_.ask({kind, number}, alike, [this](const Jobs& jobs) { serve(jobs); });
    } catch (const std::runtime_error&) {
      return false;
    }
    return true;
  }
  void wait_for(std::size_t waiting) const {
    while (gathering_.waiting() < waiting) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  void wait_until_busy() const {
    while (!busy_) std::this_thread::yield();
  }

 private:
  void serve(const Jobs& jobs) {
    ASSERT_FALSE(busy_.exchange(true)) << "two batches at once";
    std::string& numbers = batches.emplace_back();
    for (const Job* job : jobs) numbers += std::to_string(job->number);
    const auto end = [this](bool*) { busy_ = false; };
    bool here = true;
    const std::unique_ptr<bool, decltype(end)> at_the_end(&here, end);
    if (also) also(jobs);
  }

  Gathering<Job> gathering_;
  std::atomic<bool> busy_ = false;
};

/// While job 9 is being done, five others come: kinds 0 1 0 1 0. Which of the six went well.
std::string six(Shop& shop) {
  std::string well(6, '-');
  std::vector<std::thread> threads;
  threads.emplace_back([&] { well[5] = shop.ask(2, 9) ? '+' : '-'; });
  shop.wait_until_busy();
  for (std::size_t k = 0; k < 5; ++k) {
    threads.emplace_back(
        [&, k] { well[k] = shop.ask(static_cast<int>(k % 2), static_cast<int>(k)) ? '+' : '-'; });
    if (k < 4) shop.wait_for(k + 1);  // with the last they are all taken at once
  }
  for (std::thread& thread : threads) thread.join();
  return well;
}

TEST(Gathering, WhoComesMeanwhileIsServedTogetherWithThoseThatAreAlike) {
  Shop shop;
  shop.also = [&](const Jobs& jobs) {
    if (jobs[0]->number == 9) shop.wait_for(5);
  };
  EXPECT_EQ(six(shop), "++++++");
  EXPECT_EQ(shop.batches, (std::vector<std::string>{"9", "024", "13"}));
}

TEST(Gathering, AFailureIsToldToItsBatchAlone) {
  Shop shop;
  shop.also = [&](const Jobs& jobs) {
    if (jobs[0]->number == 9) shop.wait_for(5);
    if (jobs[0]->kind == 0) throw std::runtime_error("no");
  };
  EXPECT_EQ(six(shop), "-+-+-+");
  EXPECT_TRUE(shop.ask(1, 7));  // it goes on
}

TEST(Gathering, OneThatComesAloneDoesNotWait) {
  Shop shop;
  for (int k = 0; k < 3; ++k) EXPECT_TRUE(shop.ask(0, k));
  EXPECT_EQ(shop.batches, (std::vector<std::string>{"0", "1", "2"}));
}

TEST(Gathering, EverythingIsDoneOnce) {
  constexpr int kThreads = 8, kEach = 300;
  std::vector<int> done(kThreads * kEach);
  Shop shop;
  shop.also = [&](const Jobs& jobs) {
    for (const Job* job : jobs) {
      EXPECT_EQ(job->kind, jobs[0]->kind);
      ++done[static_cast<std::size_t>(job->number)];
    }
  };
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t)
    threads.emplace_back([&, t] {
      for (int k = 0; k < kEach; ++k) EXPECT_TRUE(shop.ask(k % 3, t * kEach + k));
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(std::count(done.begin(), done.end(), 1), kThreads * kEach);
}

TEST(Gathering, BetweenBatchesNothingElseIsDone) {
  std::atomic<bool> inside = false;
  Gathering<Job> gathering;
  const auto work = [&](const Jobs&) { EXPECT_FALSE(inside); };
  std::thread other([&] {
    for (int k = 0; k < 500; ++k) gathering.ask({0, k}, alike, work);
  });
  for (int k = 0; k < 500; ++k)
    gathering.between([&] {
      inside = true;
      std::this_thread::yield();
      inside = false;
    });
  other.join();
}

}  // namespace
}  // namespace parloc
