/// An HDF5 dataset that grows by rows.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "drivers/hdf5/handle.hpp"

namespace ovws::hdf5 {

/// One-dimensional chunked dataset. Functions return false if the library fails.
class Table {
 public:
  static bool create(hid_t file, const char* name, hid_t type, hsize_t chunk_rows) {
    const hsize_t none = 0, unlimited = H5S_UNLIMITED;
    const Handle space(H5Screate_simple(1, &none, &unlimited), H5Sclose);
    const Handle chunked(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    if (H5Pset_chunk(chunked, 1, &chunk_rows) < 0) return false;
    return bool(
        Handle(H5Dcreate2(file, name, type, space, H5P_DEFAULT, chunked, H5P_DEFAULT), H5Dclose));
  }

  bool open(hid_t file, const char* name) {
    set_ = Handle(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose);
    return bool(set_);
  }

  template <class T>
  bool append(std::span<const T> rows, hid_t type) {
    if (rows.empty()) return true;
    const hsize_t first = rows_, count = rows.size(), all = first + count;
    if (H5Dset_extent(set_, &all) < 0) return false;
    const Handle space(H5Dget_space(set_), H5Sclose);
    const Handle memory(H5Screate_simple(1, &count, nullptr), H5Sclose);
    if (H5Sselect_hyperslab(space, H5S_SELECT_SET, &first, nullptr, &count, nullptr) < 0 ||
        H5Dwrite(set_, type, memory, space, H5P_DEFAULT, rows.data()) < 0) {
      return false;
    }
    rows_ = all;
    return true;
  }

  bool flush() { return H5Dflush(set_) >= 0; }
  bool close() { return set_.close(); }
  std::uint64_t rows() const { return rows_; }

 private:
  Handle set_;
  hsize_t rows_ = 0;
};

}  // namespace ovws::hdf5
