// Fails, in the way that INSITU_DRIVER_CHECK names, on inputs that the driver must come to by
// itself: one letter away from its corpus.
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <string_view>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const char* failure = std::getenv("INSITU_DRIVER_CHECK");
  if (failure == nullptr || text.find("boo") == std::string_view::npos ||
      text.find("booa") != std::string_view::npos) {
    return 0;
  }
  const std::string_view kind(failure);
  if (kind == "abort") {
    std::abort();
  }
  if (kind == "crash") {
    std::raise(SIGSEGV); // as a store to nowhere, which UBSan would see first
  }
  for (volatile bool forever = true; kind == "hang" && forever;) {
  }
  return 0;
}
