// The part of CUDA's runtime that makes streams and graphs.
#include <cuda_runtime_api.h>

#include <utility>

#include "tests/ptx/runtime/lock.h"
#include "tests/ptx/runtime/report.h"
#include "tests/ptx/runtime/stream.h"

namespace {

ptx::Stream& stream_of(cudaStream_t stream) {
  if (stream == nullptr) ptx::fault("work for the default stream");
  return *reinterpret_cast<ptx::Stream*>(stream);
}

}  // namespace

extern "C" {

cudaError_t cudaStreamCreateWithFlags(cudaStream_t* stream, unsigned) {
  const ptx::RuntimeLock lock;
  *stream = reinterpret_cast<cudaStream_t>(new ptx::Stream);
  return cudaSuccess;
}

cudaError_t cudaStreamDestroy(cudaStream_t stream) {
  const ptx::RuntimeLock lock;
  delete &stream_of(stream);
  return cudaSuccess;
}

cudaError_t cudaStreamSynchronize(cudaStream_t stream) {
  const ptx::RuntimeLock lock;
  ptx::Stream::forbid_while_recording("a stream is waited for");
  ++ptx::host_counts().waits;
  stream_of(stream).run();
  return cudaSuccess;
}

cudaError_t cudaStreamBeginCapture(cudaStream_t stream, cudaStreamCaptureMode) {
  const ptx::RuntimeLock lock;
  stream_of(stream).begin_recording();
  return cudaSuccess;
}

cudaError_t cudaStreamEndCapture(cudaStream_t stream, cudaGraph_t* graph) {
  const ptx::RuntimeLock lock;
  *graph = reinterpret_cast<cudaGraph_t>(new ptx::Graph(stream_of(stream).end_recording()));
  return cudaSuccess;
}

cudaError_t cudaGraphInstantiateWithFlags(cudaGraphExec_t* executable, cudaGraph_t graph,
                                          unsigned long long) {
  const ptx::RuntimeLock lock;
  const auto& recorded = *reinterpret_cast<const ptx::Graph*>(graph);
  ++ptx::host_counts().graphs;
  ptx::host_counts().nodes += recorded.nodes.size();
  *executable = reinterpret_cast<cudaGraphExec_t>(new ptx::Graph(recorded));
  return cudaSuccess;
}

cudaError_t cudaGraphDestroy(cudaGraph_t graph) {
  const ptx::RuntimeLock lock;
  delete reinterpret_cast<ptx::Graph*>(graph);
  return cudaSuccess;
}

/// Launches that wait have taken their work along: a graph may go while it runs.
cudaError_t cudaGraphExecDestroy(cudaGraphExec_t executable) {
  const ptx::RuntimeLock lock;
  delete reinterpret_cast<ptx::Graph*>(executable);
  return cudaSuccess;
}

cudaError_t cudaGraphLaunch(cudaGraphExec_t executable, cudaStream_t stream) {
  const ptx::RuntimeLock lock;
  ++ptx::host_counts().graph_launches;
  for (const ptx::Work& node : reinterpret_cast<const ptx::Graph*>(executable)->nodes)
    stream_of(stream).add(node);
  return cudaSuccess;
}

}  // extern "C"
