#pragma once

struct CUstream_st;

/// Streams of work on a device, named without the headers of CUDA.
namespace insitu::device {

/// A stream, which is a cudaStream_t; null stands for the default stream.
using StreamHandle = CUstream_st*;

/// Waits for all work that was queued on the stream. Throws core::Error. what: the work, such as
/// "copying points".
void wait(StreamHandle stream, const char* what);
/// Waits for all work of the device.
void wait_for_all(const char* what);

/// A stream that waits for no other stream; its owner orders the work with events or waits.
class Stream {
public:
  Stream();
  ~Stream();
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  StreamHandle get() const { return stream_; }
  void wait(const char* what) const { device::wait(stream_, what); }

private:
  StreamHandle stream_ = nullptr;
};

} // namespace insitu::device
