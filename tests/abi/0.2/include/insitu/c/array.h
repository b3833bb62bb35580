/** @file array.h
 *  Arrays: views of the caller's memory. */
#ifndef INSITU_C_ARRAY_H
#define INSITU_C_ARRAY_H

#include "insitu/c/base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum insitu_type INSITU_INT {
  INSITU_FLOAT32 = 1,
  INSITU_FLOAT64 = 2,
  INSITU_INT32 = 3,
  INSITU_INT64 = 4,
  INSITU_UINT8 = 5
} insitu_type;

typedef enum insitu_memory INSITU_INT { INSITU_HOST = 0, INSITU_DEVICE = 1 } insitu_memory;

/** A view of the caller's memory; not owned, not copied.
 *  Item (i, j, k), component c lies at data + i*stride[0] + j*stride[1] + k*stride[2] +
 *  c*component_stride bytes. A one-dimensional array sets count and leaves extent 0; otherwise
 *  count is the product of the extents and item ids run i fastest. Strides may be negative.
 *  Validity: read between the commit and the return of the last call that uses the mesh in this
 *  step, hence also by insitu_session_execute. Memory may be freed or moved once the mesh is
 *  released or the array replaced. Nothing is read past the last item.
 *
 *  Items behind pointers, for solvers that keep one record a cell: with indirect 1, data is an
 * array of pointers, stride[0] bytes apart, and component c of item i lies offset +
 * c*component_stride bytes behind pointer i. Fields and the arrays of insitu_leaves may lie so, in
 * host memory. The pointers are read together with the values; a commit of INSITU_CHANGED_TOPOLOGY,
 * and the first one after the array was given, refuses a null pointer by its index. */
typedef struct insitu_array {
  size_t size;
  const void* data;
  insitu_type type;
  int32_t components;
  int64_t count;
  int64_t extent[3];
  int64_t stride[3];        /**< bytes; 0: packed */
  int64_t component_stride; /**< bytes; 0: the components of an item are adjacent */
  insitu_memory memory;
  const char* converted; /**< null, or why an adaptor had to make this copy (for the audit) */
  int32_t indirect;      /**< 1: data holds pointers to the items' records; stride[0] 0: packed */
  int64_t offset;        /**< bytes from where a pointer points to the item; 0 unless indirect */
  int64_t reserved[8];   /**< 0. Other structs hold arrays, so its size stays as it is */
} insitu_array;

static inline insitu_array insitu_array_default(void) {
  insitu_array a;
  int i;
  a.size = sizeof a;
  a.data = NULL;
  a.type = INSITU_FLOAT64;
  a.components = 1;
  a.count = 0;
  for (i = 0; i < 3; ++i)
    a.extent[i] = a.stride[i] = 0;
  a.component_stride = 0;
  a.memory = INSITU_HOST;
  a.converted = NULL;
  a.indirect = 0;
  a.offset = 0;
  for (i = 0; i < 8; ++i)
    a.reserved[i] = 0;
  return a;
}

/** A packed array of count items of components values each. */
static inline insitu_array insitu_array_of(const void* data, insitu_type type, int64_t count,
                                           int32_t components) {
  insitu_array a = insitu_array_default();
  a.data = data;
  a.type = type;
  a.count = count;
  a.components = components;
  return a;
}

#ifdef __cplusplus
}
#endif

#endif /* INSITU_C_ARRAY_H */
