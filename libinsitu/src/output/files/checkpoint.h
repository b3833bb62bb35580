#pragma once

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <span>
#include <string>
#include <string_view>

#include "core/archive.h"
#include "output/files/atomic_file.h"
#include "output/files/checksum.h"

/// Files of state: a head of 40 bytes (the magic "INSITUCP", the version and a mark of the byte
/// order as 32-bit integers, the bytes that follow, their checksum, and how many items they are, as
/// 64-bit ones) and the items, each with its name, the size and the count of its values. Numbers
/// are as the host keeps them, so that they come back to the bit; a host of another byte order
/// refuses the file. A format of our own rather than netCDF: the library that wrote it reads it
/// back, whole, and nothing of it is approximate or optional. Files are written and read item by
/// item, so that nobody holds more than the largest one.
namespace insitu::output {

/// Writes items one after the other.
class ItemWriter : public core::Archive {
public:
  bool restores() const final { return false; }
  /// Begins an item whose values put() adds, or its caller by append() of the file.
  void begin_item(std::string_view name, std::size_t item_bytes, std::size_t count);

protected:
  virtual void put(const void* data, std::size_t bytes) = 0;
  std::uint64_t items_ = 0;

private:
  void bytes(const char* name, std::size_t item_bytes, std::size_t count,
             core::FunctionRef<void*(std::size_t)> place) final;
};

/// Reads items. Throws core::Error (INSITU_ERROR_FILE) that names the file and what was expected,
/// for items other than those asked for.
class ItemReader : public core::Archive {
public:
  bool restores() const final { return true; }
  /// Reads an item to where place(count) says.
  void read(const char* name, std::size_t item_bytes, core::FunctionRef<void*(std::size_t)> place) {
    bytes(name, item_bytes, 0, place);
  }
  /// Throws if items are left.
  void require_end() const;
  /// Throws with the file's name before `message`.
  [[noreturn]] void refuse(const std::string& message) const;

protected:
  explicit ItemReader(std::string path) : path_(std::move(path)) {}
  /// Takes so many of the bytes that are left.
  virtual void take(void* to, std::size_t bytes) = 0;
  std::string path_;
  std::uint64_t at_ = 0, size_ = 0;

private:
  void bytes(const char* name, std::size_t item_bytes, std::size_t count,
             core::FunctionRef<void*(std::size_t)> place) final;
};

/// A file, which appears whole with commit() (AtomicFile).
class CheckpointWriter final : public ItemWriter {
public:
  explicit CheckpointWriter(const std::string& path);
  /// Adds values of the item that was begun last.
  void append(std::string_view bytes) { put(bytes.data(), bytes.size()); }
  void commit();

private:
  void put(const void* data, std::size_t bytes) override;
  AtomicFile file_;
  Checksum checksum_;
  std::uint64_t size_ = 0;
};

/// A file. The constructor throws core::Error (INSITU_ERROR_FILE) that names the file and what was
/// expected, for one that is absent, foreign, of another version, cut short or damaged.
class CheckpointReader final : public ItemReader {
public:
  explicit CheckpointReader(std::string path);

private:
  void take(void* to, std::size_t bytes) override;
  std::ifstream file_;
};

/// Items in memory, which are an item of a file.
class PartWriter final : public ItemWriter {
public:
  const std::string& text() const { return text_; }

private:
  void put(const void* data, std::size_t bytes) override;
  std::string text_;
};

/// The same back. path: of the file, for messages. The bytes must outlive the object.
class PartReader final : public ItemReader {
public:
  PartReader(std::string path, std::span<const std::byte> bytes);

private:
  void take(void* to, std::size_t bytes) override;
  std::span<const std::byte> bytes_;
};

} // namespace insitu::output
