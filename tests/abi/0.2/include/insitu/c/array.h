/** @file array.h
 *  Arrays are views of the caller's memory. */
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

/** A view of the caller's memory, which the library neither owns nor copies.
 *  Component c of item (i, j, k) lies at data + i*stride[0] + j*stride[1] + k*stride[2] +
 *  c*component_stride bytes. A one-dimensional array sets count and leaves extent 0. In any other
 *  array count is the product of the extents, and item ids run i fastest. Strides may be negative.
 *
 *  Validity: the library reads the memory from the commit to the return of the last call that uses
 *  the mesh in this step, insitu_session_execute among them. The caller may free or move the memory
 *  once the mesh is released or the array replaced. The library reads nothing past the last item.
 *
 *  Items behind pointers serve solvers that keep one record a cell: where indirect is 1, data is an
 *  array of pointers, stride[0] bytes apart, and component c of item i lies
 *  offset + c*component_stride bytes behind pointer i. Fields, the arrays of insitu_leaves and the
 *  vertices of insitu_faces may lie so, in host memory. The library reads the pointers whenever it
 * reads the values. A commit of INSITU_CHANGED_TOPOLOGY, and the first commit after the array was
 * given, refuses a null pointer and names its index. */
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
  const char* converted; /**< why an adaptor had to make this copy (for the audit); null: no copy */
  int32_t indirect;      /**< 1: data holds pointers to the items' records, packed if stride[0]
                              is 0 */
  int64_t offset;        /**< bytes from the place that a pointer names to the item; 0 unless
                              indirect is 1 */
  int64_t reserved[8];   /**< always 0. Other structs hold arrays, so the size of this one stays as
                              it is */
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

/** Makes a packed array in host memory of count items with as many values each as components
 *  says. */
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
