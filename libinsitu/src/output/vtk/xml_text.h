#pragma once

#include <string>
#include <string_view>

namespace insitu::output {

/// Text fit for an XML attribute: & < > " and line breaks as entities, other control characters as
/// blanks (XML has no way to write them).
std::string xml_escape(std::string_view text);
/// The reverse, for the entities that xml_escape makes.
std::string xml_unescape(std::string_view text);

} // namespace insitu::output
