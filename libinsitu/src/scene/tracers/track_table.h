#pragma once

#include "scene/tracers/track_writer.h"

namespace insitu::scene {

/// A table that grows: a row for each living particle when due, and a last one for each that ends,
/// in the cycle in which it does. Those that are alive when the session closes end as killed, with
/// no cell and no values of fields. The formats derive from it.
class TrackTable : public TrackWriter {
public:
  void write(TrackCycle& cycle) final;
  void finish(const advect::Particles& particles, const TrackGeodesics& geodesics,
              std::int64_t cycle, double time) final;
  void keep(core::Archive& archive) final;

protected:
  /// Opens the file, or throws if one that is open does not fit these rows.
  virtual void open(const TrackRows& rows, std::int64_t seeded) = 0;
  virtual bool is_open() const = 0;
  /// Adds rows to those that wait for flush(). Does not throw but for want of memory.
  virtual void add(const TrackRows& rows) = 0;
  virtual void flush() = 0;
  virtual void close() = 0;
  /// How much is in the open file, and back to that: bytes or records.
  virtual std::int64_t size() const = 0;
  virtual void shorten(std::int64_t size) = 0;
  /// The same with the rows that wait.
  virtual std::int64_t end() const = 0;
  virtual void cut_back(std::int64_t end) = 0;
  /// The columns of the open file's values.
  virtual const std::vector<std::string>& value_columns() const = 0;
  /// How the open file names cells.
  virtual const CellNames& cell_names() const = 0;

private:
  void take_back();

  std::vector<std::uint8_t> written_;           ///< [id] 1: the row of its ending is in the table
  // Of the last step.
  StepNote note_;
  std::optional<std::int64_t> begin_; ///< where its rows begin: end() then; if some were added
  std::vector<std::int64_t> ended_;   ///< the ids that written_ was told
  insitu_frame frame_ = insitu_frame_default(); ///< with which the file was opened
};

} // namespace insitu::scene
