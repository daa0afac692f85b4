/// Datasets of a recording that grow while it is written, and their attributes.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "drivers/hdf5/handle.hpp"

namespace ovws::hdf5 {

// Functions return false if the library fails.

bool write_attribute(hid_t on, const std::string& name, hid_t type, const void* value);
/// Writes a UTF-8 attribute of variable length, which h5py reads as str; fixed length would be read
/// as bytes.
bool write_attribute(hid_t on, const std::string& name, const std::string& text);

/// One-dimensional chunked dataset that grows by rows.
class Table {
 public:
  static bool create(hid_t file, const char* name, hid_t type, hsize_t chunk_rows);
  bool open(hid_t file, const char* name);

  template <class T>
  bool append(std::span<const T> rows, hid_t type) {
    return write(rows_, rows.size(), rows.data(), type);
  }
  /// Replaces the first rows, and appends the further ones.
  template <class T>
  bool overwrite(std::span<const T> rows, hid_t type) {
    return write(0, rows.size(), rows.data(), type);
  }

  bool flush() { return H5Dflush(set_) >= 0; }
  bool close() { return set_.close(); }
  std::uint64_t rows() const { return rows_; }

 private:
  bool write(hsize_t first, hsize_t count, const void* rows, hid_t type);

  Handle set_;
  hsize_t rows_ = 0;
};

/// Two-dimensional chunked dataset that grows by rows, and by columns when a row has more cells
/// than any before. Cells that a row lacks have the fill value.
class Matrix {
 public:
  /// A row is expected to have `columns` cells; the chunks are made for that.
  static bool create(hid_t file, const char* name, hid_t type, hsize_t columns, const void* fill);
  bool open(hid_t file, const char* name);

  /// Appends rows: the k-th has the next cells_per_row[k] of `cells`.
  template <class T>
  bool append(std::span<const T> cells, std::span<const std::uint32_t> cells_per_row, hid_t type) {
    return write(cells.data(), sizeof(T), cells_per_row, type);
  }

  bool flush() { return H5Dflush(set_) >= 0; }
  bool close() { return set_.close(); }
  bool is_open() const { return bool(set_); }
  hsize_t columns() const { return columns_; }

 private:
  bool write(const void* cells, std::size_t cell_bytes, std::span<const std::uint32_t> per_row,
             hid_t type);

  Handle set_;
  hsize_t rows_ = 0, columns_ = 0;
};

/// Makes the dataset `scale` a dimension scale of that name, of dimension `dimension` of the other
/// datasets.
struct ScaledDimension {
  const char* dataset;
  unsigned dimension;
};
bool make_scale(hid_t file, const char* scale, std::span<const ScaledDimension> of);

}  // namespace ovws::hdf5
