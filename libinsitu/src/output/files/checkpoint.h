#pragma once

#include <string>

#include "core/archive.h"

/// Files of state: a head of 40 bytes (the magic "INSITUCP", the version and a mark of the byte
/// order as 32-bit integers, the bytes that follow, their checksum, and how many items they are, as
/// 64-bit ones) and the items, each with its name, the size and the count of its values. Numbers
/// are as the host keeps them, so that they come back to the bit; a host of another byte order
/// refuses the file. A format of our own rather than netCDF: the library that wrote it reads it
/// back, whole, and nothing of it is approximate or optional.
namespace insitu::output {

class CheckpointWriter final : public core::Archive {
public:
  bool restores() const override { return false; }
  /// Writes the file, atomically (AtomicFile).
  void commit(const std::string& path) const;

private:
  void bytes(const char* name, std::size_t item_bytes, std::size_t count,
             core::FunctionRef<void*(std::size_t)> place) override;
  std::string body_;
  std::uint64_t items_ = 0;
};

/// Reads the whole file at once. Throws core::Error (INSITU_ERROR_FILE) that names the file and
/// what was expected, for one that is absent, foreign, of another version, cut short or damaged;
/// and from then on for items other than those asked for.
class CheckpointReader final : public core::Archive {
public:
  explicit CheckpointReader(std::string path);
  bool restores() const override { return true; }
  const std::string& path() const { return path_; }
  /// Throws if items are left.
  void require_end() const;
  /// Throws with the file's name before `message`.
  [[noreturn]] void refuse(const std::string& message) const;

private:
  void bytes(const char* name, std::size_t item_bytes, std::size_t count,
             core::FunctionRef<void*(std::size_t)> place) override;
  std::string path_, body_;
  std::size_t at_ = 0;
};

} // namespace insitu::output
