#include "core/caller_struct.h"

// No struct ends with padding: a member that a later version put there would be what an earlier
// caller never set.
#define ENDS_WITH(type, member)                                                                    \
  static_assert(offsetof(type, member) + sizeof(type::member) == sizeof(type))
ENDS_WITH(insitu_advance_args, stream);
ENDS_WITH(insitu_amr, reserved);
ENDS_WITH(insitu_amr_info, by_places);
ENDS_WITH(insitu_array, reserved);
ENDS_WITH(insitu_audit_entry, reserved);
ENDS_WITH(insitu_block, reserved);
ENDS_WITH(insitu_cells, reserved);
ENDS_WITH(insitu_commit_report, reserved);
ENDS_WITH(insitu_faces, cell_offsets);
ENDS_WITH(insitu_frame, reserved);
ENDS_WITH(insitu_leaves, offset);
ENDS_WITH(insitu_locate_args, reserved);
ENDS_WITH(insitu_locator, backend);
ENDS_WITH(insitu_locator_info, settled_on_host);
ENDS_WITH(insitu_patch, ghosts_after);
ENDS_WITH(insitu_report, bytes_sent);
ENDS_WITH(insitu_sample_args, values);
ENDS_WITH(insitu_session_options, preview);
ENDS_WITH(insitu_validation, covered_vertices);
ENDS_WITH(insitu_vertices_args, places);
#undef ENDS_WITH

namespace insitu::core::detail {

void refuse_size(const std::string& what, const char* name, std::size_t size, std::size_t least,
                 std::size_t most) {
  std::string expected = std::to_string(least);
  if (size > most)
    expected = least == most ? expected : "at most " + std::to_string(most);
  else if (least != most)
    expected += size < least ? " or more" : " and more by whole words";
  throw Error(INSITU_ERROR_ARGUMENT, what + ": size is " + std::to_string(size) + ", " + expected +
                                         " expected of " + name + "; make it with " + name +
                                         "_default()");
}

void expect_zeros(const void* given, std::size_t begin, std::size_t end, const std::string& what,
                  const char* name, std::size_t known) {
  const auto* const bytes = static_cast<const unsigned char*>(given);
  for (std::size_t i = begin; i < end; ++i)
    if (bytes[i] != 0)
      throw Error(
          INSITU_ERROR_ARGUMENT,
          what + ": byte " + std::to_string(i) + " of " + name + " is " +
              std::to_string(int(bytes[i])) + ", 0 expected: version " + INSITU_VERSION_STRING +
              " knows " +
              (begin < known ? "no member there" : std::to_string(known) + " bytes of it") +
              ". Either the caller needs a later version, or the struct was not made with " + name +
              "_default()");
}

} // namespace insitu::core::detail
