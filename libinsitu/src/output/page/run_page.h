#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "output/files/append_file.h"

namespace insitu::output {

/// The page of a run: `index.html`, the same for every run and written once, and beside it
/// `run.js`, a script that grows by a line an entry, so that a cycle costs the same however long
/// the run. Open the page from the file system; it asks for nothing else.
///
/// A line of `run.js` is a comment until it is whole: a script that a kill or a full disk cut short
/// still runs, and shows what came before. The next opening removes the partial line.
///
/// One writer at a time, as AppendFile: BeingWritten is thrown to a second one. Files of these
/// names that this library did not write are left alone, and that is an error. All are core::Error
/// (INSITU_ERROR_FILE).
class RunPage {
public:
  static constexpr const char* page_name = "index.html";
  static constexpr const char* data_name = "run.js";

  /// from: entries of an earlier run of this cycle and later go, since a run that restarted makes
  /// them again.
  RunPage(const std::string& folder, std::int64_t from);

  /// An entry: a JSON object in one line whose first key is "cycle".
  void add(std::string_view entry);
  /// Takes back the last entry that was added.
  void take_back();

private:
  std::int64_t last_ = 0; ///< where that begins; 0: there is none
  AppendFile data_;
};

} // namespace insitu::output
