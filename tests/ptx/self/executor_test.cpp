// The executor sees each planted fault, and says what it is; what is right runs and gives the right numbers.
#include <gtest/gtest.h>

#include <cstdlib>
#include <numeric>
#include <vector>

#include "tests/ptx/runtime/report.h"
#include "tests/ptx/runtime/settings.h"
#include "tests/ptx/self/kernels.h"

namespace ptx_test {
namespace {

using Numbers = std::vector<std::uint32_t>;

/// Device memory with numbers in it, and a stream.
struct Room {
  cudaStream_t stream = nullptr;
  std::uint32_t* data = nullptr;
  std::size_t bytes;
  explicit Room(const Numbers& numbers) : bytes(numbers.size() * sizeof(std::uint32_t)) {
    cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking);
    cudaMalloc(reinterpret_cast<void**>(&data), bytes);
    cudaMemcpyAsync(data, numbers.data(), bytes, cudaMemcpyHostToDevice, stream);
    cudaStreamSynchronize(stream);
  }
  ~Room() {
    cudaFree(data);
    cudaStreamDestroy(stream);
  }
  Numbers read() const {
    Numbers numbers(bytes / sizeof(std::uint32_t));
    cudaMemcpyAsync(numbers.data(), data, bytes, cudaMemcpyDeviceToHost, stream);
    cudaStreamSynchronize(stream);
    return numbers;
  }
};

Numbers counted(std::size_t count) {
  Numbers numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0u);
  return numbers;
}

Numbers run(Which which, const Numbers& numbers, unsigned blocks, unsigned threads) {
  const Room room(numbers);
  start(which, room.data, blocks, threads, room.stream);
  return room.read();
}

/// For death tests: runs it, and ends as a program would.
void run_to_the_end(Which which, std::size_t count, unsigned blocks, unsigned threads) {
  run(which, counted(count), blocks, threads);
  std::exit(0);
}

TEST(Executor, WarpsShuffleVoteAndReduce) {
  const Numbers found = run(Which::sum_in_warp, counted(64), 1, 64);
  for (std::uint32_t i = 0; i < 64; ++i) {
    const std::uint32_t first = i / 32 * 32, sum = 32 * first + 31 * 16, k = i - first + 1;
    const std::uint32_t scan = k * first + k * (k - 1) / 2;
    EXPECT_EQ(found[i], sum * (i < 32 ? 3 : 5) + scan + 16 + first + 31 + (i < 32 ? 1 : 0) + 2) << i;
  }
}

TEST(Executor, LastBlockReadsWhatOthersPublished) {
  EXPECT_EQ(run(Which::sum_of_blocks, Numbers(102), 100, 64)[0], 5050u);
}

TEST(Executor, DynamicSharedMemoryAndTwoDimensions) {
  const Numbers found = run(Which::dynamic_shared, counted(4 * 96), 2, 96);
  for (std::uint32_t i = 0; i < found.size(); ++i) EXPECT_EQ(found[i], i / 96 * 96 + 95 - i % 96);
}

struct Fault {
  Which which;
  std::size_t count;
  unsigned blocks, threads;
  int code;
  const char* says;
};
class Faults : public testing::TestWithParam<Fault> {};

TEST_P(Faults, IsSeen) {
  const Fault& f = GetParam();
  EXPECT_EXIT(run_to_the_end(f.which, f.count, f.blocks, f.threads), testing::ExitedWithCode(f.code), f.says);
}

constexpr int kFault = ptx::kFaultExit, kRace = ptx::kRaceExit;
INSTANTIATE_TEST_SUITE_P(
    All, Faults,
    testing::Values(
        Fault{Which::out_of_bounds, 32, 1, 32, kFault, "out_of_bounds.*4 bytes out of bounds, at 128"},
        Fault{Which::misaligned, 32, 1, 1, kFault, "misaligned: 4 bytes"},
        Fault{Which::race_in_block, 64, 1, 64, kRace,
              "race: ptx_test::race_in_block.*shared memory that another thread"},
        Fault{Which::race_of_blocks, 1, 2, 32, kRace,
              "race: ptx_test::race_of_blocks.*global memory that another block"},
        Fault{Which::unfenced_sum, 12, 10, 32, kRace,
              "race: ptx_test::sum_of_blocks.*global memory that another block"},
        Fault{Which::divergent_barrier, 32, 1, 32, kFault, "threads of one warp are at different barriers"},
        Fault{Which::wrong_mask, 32, 1, 32, kFault, "lanes that its mask names do not come: 8, 9"},
        Fault{Which::not_in_mask, 32, 1, 32, kFault, "the mask does not name lane"},
        Fault{Which::shared_bounds, 32, 1, 32, kFault, "out of bounds.*of 16 bytes of shared memory"}));

TEST(Faults, FreedMemory) {
  EXPECT_EXIT(
      {
        Room room(counted(32));
        start(Which::sum_in_warp, room.data + 0, 1, 32, room.stream);
        cudaStreamSynchronize(room.stream);
        cudaFree(room.data);
        start(Which::sum_in_warp, room.data, 1, 32, room.stream);
        cudaStreamSynchronize(room.stream);
      },
      testing::ExitedWithCode(kFault), "of freed memory");
}

TEST(Faults, AllocationWhileRecording) {
  EXPECT_EXIT(
      {
        Room room(counted(32));
        cudaStreamBeginCapture(room.stream, cudaStreamCaptureModeThreadLocal);
        void* more = nullptr;
        cudaMalloc(&more, 16);
      },
      testing::ExitedWithCode(kFault), "memory is allocated while a stream is recorded");
}

TEST(Faults, PageableCopyWhileRecording) {
  EXPECT_EXIT(
      {
        Room room(counted(32));
        cudaStreamBeginCapture(room.stream, cudaStreamCaptureModeThreadLocal);
        const Numbers numbers(4);
        cudaMemcpyAsync(room.data, numbers.data(), 16, cudaMemcpyHostToDevice, room.stream);
      },
      testing::ExitedWithCode(kFault), "a copy of pageable memory is recorded");
}

TEST(Faults, HostBufferThatChangesTooEarly) {
  EXPECT_EXIT(
      {
        ptx::settings().late_copies = true;
        Numbers numbers = counted(32);
        Room room(numbers);
        cudaMemcpyAsync(room.data, numbers.data(), room.bytes, cudaMemcpyHostToDevice, room.stream);
        numbers[3] = 7;
        cudaStreamSynchronize(room.stream);
      },
      testing::ExitedWithCode(kFault), "changed or freed its buffer of 128 bytes");
}

TEST(Faults, HostReadsDeviceMemory) {
  EXPECT_EXIT(
      {
        const Room room(counted(32));
        std::exit(static_cast<int>(*static_cast<volatile std::uint32_t*>(room.data)));
      },
      testing::ExitedWithCode(kFault), "the host touched memory of the device");
}

TEST(Faults, ChosenAllocationFails) {
  EXPECT_EXIT(
      {
        ptx::settings().failing = ptx::host_counts().allocations + 2;
        void* at = nullptr;
        const bool first = cudaMalloc(&at, 16) == cudaSuccess;
        const bool second = cudaMalloc(&at, 16) == cudaErrorMemoryAllocation;
        std::exit(first && second ? 5 : 6);
      },
      testing::ExitedWithCode(5), "");
}

}  // namespace
}  // namespace ptx_test
