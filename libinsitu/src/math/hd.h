#pragma once

/// Marks a function that compilers make for the host and, under nvcc, for the device.
#if defined(__CUDACC__)
#define INSITU_HD __host__ __device__
#else
#define INSITU_HD
#endif
