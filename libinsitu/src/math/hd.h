#pragma once

/// Marks a function that compilers make for the host and, under nvcc, for the device.
#if defined(__CUDACC__)
#define INSITU_HD __host__ __device__
#else
#define INSITU_HD
#endif

/// Before a loop of kernels for a device: its steps become registers, or the loop stays a loop.
#if defined(__CUDACC__)
#define INSITU_UNROLL _Pragma("unroll")
#define INSITU_NO_UNROLL _Pragma("unroll 1")
#else
#define INSITU_UNROLL
#define INSITU_NO_UNROLL
#endif
