/* For catalyst.h: Conduit's functions by the names that they have in libcatalyst. */
#define conduit_node_create catalyst_conduit_node_create
#define conduit_node_destroy catalyst_conduit_node_destroy
#define conduit_node_fetch catalyst_conduit_node_fetch
#define conduit_node_fetch_existing catalyst_conduit_node_fetch_existing
#define conduit_node_append catalyst_conduit_node_append
#define conduit_node_child catalyst_conduit_node_child
#define conduit_node_number_of_children catalyst_conduit_node_number_of_children
#define conduit_node_name catalyst_conduit_node_name
#define conduit_node_has_path catalyst_conduit_node_has_path
#define conduit_node_remove_path catalyst_conduit_node_remove_path
#define conduit_node_dtype catalyst_conduit_node_dtype
#define conduit_node_element_ptr catalyst_conduit_node_element_ptr
#define conduit_node_as_char8_str catalyst_conduit_node_as_char8_str
#define conduit_node_as_int64 catalyst_conduit_node_as_int64
#define conduit_node_as_float64 catalyst_conduit_node_as_float64
#define conduit_datatype_sizeof_index_t catalyst_conduit_datatype_sizeof_index_t
#define conduit_datatype_id catalyst_conduit_datatype_id
#define conduit_datatype_number_of_elements catalyst_conduit_datatype_number_of_elements
#define conduit_datatype_offset catalyst_conduit_datatype_offset
#define conduit_datatype_stride catalyst_conduit_datatype_stride
#define conduit_datatype_element_bytes catalyst_conduit_datatype_element_bytes
#define conduit_datatype_endianness_matches_machine                                                \
  catalyst_conduit_datatype_endianness_matches_machine
#define conduit_node_set_path_char8_str catalyst_conduit_node_set_path_char8_str
#define conduit_node_set_path_int8 catalyst_conduit_node_set_path_int8
#define conduit_node_set_path_int8_ptr catalyst_conduit_node_set_path_int8_ptr
#define conduit_node_set_path_external_int8_ptr catalyst_conduit_node_set_path_external_int8_ptr
#define conduit_node_set_path_external_int8_ptr_detailed                                           \
  catalyst_conduit_node_set_path_external_int8_ptr_detailed
#define conduit_node_set_path_int16 catalyst_conduit_node_set_path_int16
#define conduit_node_set_path_int16_ptr catalyst_conduit_node_set_path_int16_ptr
#define conduit_node_set_path_external_int16_ptr catalyst_conduit_node_set_path_external_int16_ptr
#define conduit_node_set_path_external_int16_ptr_detailed                                          \
  catalyst_conduit_node_set_path_external_int16_ptr_detailed
#define conduit_node_set_path_int32 catalyst_conduit_node_set_path_int32
#define conduit_node_set_path_int32_ptr catalyst_conduit_node_set_path_int32_ptr
#define conduit_node_set_path_external_int32_ptr catalyst_conduit_node_set_path_external_int32_ptr
#define conduit_node_set_path_external_int32_ptr_detailed                                          \
  catalyst_conduit_node_set_path_external_int32_ptr_detailed
#define conduit_node_set_path_int64 catalyst_conduit_node_set_path_int64
#define conduit_node_set_path_int64_ptr catalyst_conduit_node_set_path_int64_ptr
#define conduit_node_set_path_external_int64_ptr catalyst_conduit_node_set_path_external_int64_ptr
#define conduit_node_set_path_external_int64_ptr_detailed                                          \
  catalyst_conduit_node_set_path_external_int64_ptr_detailed
#define conduit_node_set_path_uint8 catalyst_conduit_node_set_path_uint8
#define conduit_node_set_path_uint8_ptr catalyst_conduit_node_set_path_uint8_ptr
#define conduit_node_set_path_external_uint8_ptr catalyst_conduit_node_set_path_external_uint8_ptr
#define conduit_node_set_path_external_uint8_ptr_detailed                                          \
  catalyst_conduit_node_set_path_external_uint8_ptr_detailed
#define conduit_node_set_path_uint16 catalyst_conduit_node_set_path_uint16
#define conduit_node_set_path_uint16_ptr catalyst_conduit_node_set_path_uint16_ptr
#define conduit_node_set_path_external_uint16_ptr catalyst_conduit_node_set_path_external_uint16_ptr
#define conduit_node_set_path_external_uint16_ptr_detailed                                         \
  catalyst_conduit_node_set_path_external_uint16_ptr_detailed
#define conduit_node_set_path_uint32 catalyst_conduit_node_set_path_uint32
#define conduit_node_set_path_uint32_ptr catalyst_conduit_node_set_path_uint32_ptr
#define conduit_node_set_path_external_uint32_ptr catalyst_conduit_node_set_path_external_uint32_ptr
#define conduit_node_set_path_external_uint32_ptr_detailed                                         \
  catalyst_conduit_node_set_path_external_uint32_ptr_detailed
#define conduit_node_set_path_uint64 catalyst_conduit_node_set_path_uint64
#define conduit_node_set_path_uint64_ptr catalyst_conduit_node_set_path_uint64_ptr
#define conduit_node_set_path_external_uint64_ptr catalyst_conduit_node_set_path_external_uint64_ptr
#define conduit_node_set_path_external_uint64_ptr_detailed                                         \
  catalyst_conduit_node_set_path_external_uint64_ptr_detailed
#define conduit_node_set_path_float32 catalyst_conduit_node_set_path_float32
#define conduit_node_set_path_float32_ptr catalyst_conduit_node_set_path_float32_ptr
#define conduit_node_set_path_external_float32_ptr                                                 \
  catalyst_conduit_node_set_path_external_float32_ptr
#define conduit_node_set_path_external_float32_ptr_detailed                                        \
  catalyst_conduit_node_set_path_external_float32_ptr_detailed
#define conduit_node_set_path_float64 catalyst_conduit_node_set_path_float64
#define conduit_node_set_path_float64_ptr catalyst_conduit_node_set_path_float64_ptr
#define conduit_node_set_path_external_float64_ptr                                                 \
  catalyst_conduit_node_set_path_external_float64_ptr
#define conduit_node_set_path_external_float64_ptr_detailed                                        \
  catalyst_conduit_node_set_path_external_float64_ptr_detailed
