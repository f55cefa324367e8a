// A queue of work for the device, and work recorded once to be started as one piece. Compiled by nvcc this is
// a CUDA stream and a CUDA graph; compiled as C++ work runs at once on the host, and a recording keeps the
// very arguments it was made with, so that the tests see what a device would see.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/error.h"

#if defined(__CUDACC__)
#include <cuda_runtime.h>
#define PARLOC_CUDA_NAMESPACE cuda
#else
#define PARLOC_CUDA_NAMESPACE cuda_on_host
#endif

namespace parloc::PARLOC_CUDA_NAMESPACE {

/// A filter's step as a list (cuda/sequence.h), which a stream may have to note instead of starting anything.
class Sequence;

#if defined(__CUDACC__)
inline void check(cudaError_t status, const char* what, const char* file, int line) {
  if (status == cudaSuccess) return;
  (void)cudaGetLastError();  // or the next launch would report this error once more
  throw Error(ErrorKind::internal, std::string(file) + ":" + std::to_string(line) + ": CUDA failed while " +
                                       what + ": " + cudaGetErrorString(status));
}
#define PARLOC_CHECK(call, what) ::parloc::PARLOC_CUDA_NAMESPACE::check((call), (what), __FILE__, __LINE__)

struct DeviceStream {
  cudaStream_t handle = nullptr;
  bool owns = true;
  Sequence* noting = nullptr;  ///< Null: work is started.
};
using Stream = DeviceStream*;

inline Stream make_stream() {
  auto stream = std::make_unique<DeviceStream>();
  PARLOC_CHECK(cudaStreamCreateWithFlags(&stream->handle, cudaStreamNonBlocking), "creating a stream");
  return stream.release();
}
/// Another end of the same, which goes first.
inline Stream share_stream(Stream s) {
  return new DeviceStream{s->handle, false};
}
inline void free_stream(Stream s) {
  if (s != nullptr && s->owns) (void)cudaStreamDestroy(s->handle);
  delete s;
}
inline void synchronise(Stream s) {
  PARLOC_CHECK(cudaStreamSynchronize(s->handle), "waiting for the device");
}
/// Every later call of this host thread is meant for this device.
inline void select_device(int device) {
  PARLOC_CHECK(cudaSetDevice(device), "selecting the device");
}

/// Work recorded from a stream.
class Recording {
 public:
  template <class Work>
  Recording(Stream stream, const Work& work) {
    PARLOC_CHECK(cudaStreamBeginCapture(stream->handle, cudaStreamCaptureModeThreadLocal),
                 "recording a step");
    cudaGraph_t graph = nullptr;
    try {
      work();
    } catch (...) {  // the stream must not stay in recording
      (void)cudaStreamEndCapture(stream->handle, &graph);
      if (graph != nullptr) (void)cudaGraphDestroy(graph);
      throw;
    }
    PARLOC_CHECK(cudaStreamEndCapture(stream->handle, &graph), "recording a step");
    const cudaError_t status = cudaGraphInstantiateWithFlags(&executable_, graph, 0);
    (void)cudaGraphDestroy(graph);
    PARLOC_CHECK(status, "preparing a recorded step");
  }
  ~Recording() { (void)cudaGraphExecDestroy(executable_); }
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;
  void start(Stream stream) const {
    PARLOC_CHECK(cudaGraphLaunch(executable_, stream->handle), "starting a recorded step");
  }

 private:
  cudaGraphExec_t executable_ = nullptr;
};
#else
struct HostStream {
  std::vector<std::function<void()> >* recording = nullptr;
  Sequence* noting = nullptr;
};
using Stream = HostStream*;  ///< Null: everything runs at once.

/// Runs now, or each time that the recording is started.
template <class Work>
void submit(Stream stream, const Work& work) {
  if (stream == nullptr || stream->recording == nullptr)
    work();
  else
    stream->recording->push_back(work);
}

inline Stream make_stream() {
  return new HostStream;
}
inline Stream share_stream(Stream) {
  return make_stream();
}
inline void free_stream(Stream s) {
  delete s;
}
inline void synchronise(Stream s) {
  if (s != nullptr && s->recording != nullptr)
    throw Error(ErrorKind::internal, "a stream cannot be waited for while it is recorded");
}
inline void select_device(int) {}

class Recording {
 public:
  template <class Work>
  Recording(Stream stream, const Work& work) {
    stream->recording = &pieces_;
    work();
    stream->recording = nullptr;
  }
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;
  void start(Stream) const {
    for (const auto& piece : pieces_) piece();
  }

 private:
  std::vector<std::function<void()> > pieces_;
};
#endif

/// Work that is the same every time but for what lies in memory. It is done piece by piece the first time,
/// which also loads its kernels, recorded the second time, and started as one piece from then on.
class Repeated {
 public:
  template <class Work>
  void run(Stream stream, const Work& work) {
    if (!seen_) {
      seen_ = true;
      work();
      return;
    }
    if (recording_ == nullptr) recording_ = std::make_unique<Recording>(stream, work);
    recording_->start(stream);
  }

 private:
  bool seen_ = false;
  std::unique_ptr<Recording> recording_;
};

}  // namespace parloc::PARLOC_CUDA_NAMESPACE
