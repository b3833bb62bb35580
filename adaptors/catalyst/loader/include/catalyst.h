/** @file catalyst.h
 *  The part of Catalyst 2's C interface that the example, the tests and recorded dumps need, for
 *  machines on which Catalyst is not installed. Where it is, its own catalyst.h serves instead:
 *  names, arguments and meaning are the same. Nothing of this is installed. */
#ifndef catalyst_h
#define catalyst_h

#include <stdint.h>

#ifndef INSITU_OWN_CONDUIT /* as Catalyst names the functions of the Conduit that is part of it */
#include "catalyst_conduit_names.h"
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef struct conduit_node_impl conduit_node;
typedef struct conduit_datatype_impl conduit_datatype;
typedef int64_t conduit_index_t;

conduit_node* conduit_node_create(void);
void conduit_node_destroy(conduit_node* node);
conduit_node* conduit_node_fetch(conduit_node* node, const char* path);
conduit_node* conduit_node_fetch_existing(conduit_node* node, const char* path);
conduit_node* conduit_node_append(conduit_node* node);
conduit_node* conduit_node_child(conduit_node* node, conduit_index_t index);
conduit_index_t conduit_node_number_of_children(conduit_node* node);
char* conduit_node_name(const conduit_node* node);
int conduit_node_has_path(const conduit_node* node, const char* path);
void conduit_node_remove_path(conduit_node* node, const char* path);
const conduit_datatype* conduit_node_dtype(const conduit_node* node);
void* conduit_node_element_ptr(conduit_node* node, conduit_index_t index);
char* conduit_node_as_char8_str(conduit_node* node);
int64_t conduit_node_as_int64(conduit_node* node);
double conduit_node_as_float64(conduit_node* node);

conduit_index_t conduit_datatype_sizeof_index_t(void);
conduit_index_t conduit_datatype_id(const conduit_datatype* type);
conduit_index_t conduit_datatype_number_of_elements(const conduit_datatype* type);
conduit_index_t conduit_datatype_offset(const conduit_datatype* type);
conduit_index_t conduit_datatype_stride(const conduit_datatype* type);
conduit_index_t conduit_datatype_element_bytes(const conduit_datatype* type);
int conduit_datatype_endianness_matches_machine(const conduit_datatype* type);

void conduit_node_set_path_char8_str(conduit_node* node, const char* path, const char* text);

/* Of each type: one number; a copy of n numbers; n numbers where they are, packed, or from an
 * offset on with a stride, in bytes. */
#define INSITU_CONDUIT_TYPE(name, type)                                                            \
  void conduit_node_set_path_##name(conduit_node* node, const char* path, type value);             \
  void conduit_node_set_path_##name##_ptr(conduit_node* node, const char* path, type* data,        \
                                          conduit_index_t n);                                      \
  void conduit_node_set_path_external_##name##_ptr(conduit_node* node, const char* path,           \
                                                   type* data, conduit_index_t n);                 \
  void conduit_node_set_path_external_##name##_ptr_detailed(                                       \
      conduit_node* node, const char* path, type* data, conduit_index_t n, conduit_index_t offset, \
      conduit_index_t stride, conduit_index_t element_bytes, conduit_index_t endianness);
#define INSITU_CONDUIT_TYPES                                                                       \
  INSITU_CONDUIT_TYPE(int8, int8_t)                                                                \
  INSITU_CONDUIT_TYPE(int16, int16_t)                                                              \
  INSITU_CONDUIT_TYPE(int32, int32_t)                                                              \
  INSITU_CONDUIT_TYPE(int64, int64_t)                                                              \
  INSITU_CONDUIT_TYPE(uint8, uint8_t)                                                              \
  INSITU_CONDUIT_TYPE(uint16, uint16_t)                                                            \
  INSITU_CONDUIT_TYPE(uint32, uint32_t)                                                            \
  INSITU_CONDUIT_TYPE(uint64, uint64_t)                                                            \
  INSITU_CONDUIT_TYPE(float32, float)                                                              \
  INSITU_CONDUIT_TYPE(float64, double)
INSITU_CONDUIT_TYPES
#undef INSITU_CONDUIT_TYPE

enum catalyst_status {
  catalyst_status_ok = 0,
  catalyst_status_error_no_implementation,
  catalyst_status_error_already_loaded,
  catalyst_status_error_not_found,
  catalyst_status_error_not_catalyst,
  catalyst_status_error_incomplete,
  catalyst_status_error_unsupported_version,
  catalyst_status_largest = 0x3fffffff /* implementations return numbers of their own below it */
};

/* The first call loads libcatalyst-NAME.so, NAME being catalyst_load/implementation or the
 * environment's CATALYST_IMPLEMENTATION_NAME, from one of the folders in
 * CATALYST_IMPLEMENTATION_PATHS. */
enum catalyst_status catalyst_initialize(const conduit_node* parameters);
enum catalyst_status catalyst_execute(const conduit_node* parameters);
enum catalyst_status catalyst_finalize(const conduit_node* parameters);
enum catalyst_status catalyst_about(conduit_node* parameters);
enum catalyst_status catalyst_results(conduit_node* parameters);

#ifdef __cplusplus
}
#endif

#endif /* catalyst_h */
