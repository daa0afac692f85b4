#include "drivers/record/tables.hpp"

#include <hdf5_hl.h>

#include <algorithm>
#include <array>

namespace ovws::hdf5 {
namespace {

// Limits of a chunk: it fits into HDF5's cache of 1 MiB, and the last one may be almost empty.
constexpr hsize_t kMatrixChunkBytes = 400 << 10;
constexpr hsize_t kMatrixChunkRows = 1024;

bool write_cells(hid_t set, std::array<hsize_t, 2> at, std::array<hsize_t, 2> size,
                 const void* cells, hid_t type) {
  const Handle space(H5Dget_space(set), H5Sclose);
  const Handle memory(H5Screate_simple(2, size.data(), nullptr), H5Sclose);
  return H5Sselect_hyperslab(space, H5S_SELECT_SET, at.data(), nullptr, size.data(), nullptr) >=
             0 &&
         H5Dwrite(set, type, memory, space, H5P_DEFAULT, cells) >= 0;
}

}  // namespace

bool write_attribute(hid_t on, const std::string& name, hid_t type, const void* value) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle attribute(H5Acreate2(on, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
  return attribute && H5Awrite(attribute, type, value) >= 0;
}

bool write_attribute(hid_t on, const std::string& name, const std::string& text) {
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  const char* const value = text.c_str();
  return write_attribute(on, name, type, static_cast<const void*>(&value));
}

bool Table::create(hid_t file, const char* name, hid_t type, hsize_t chunk_rows) {
  const hsize_t none = 0, unlimited = H5S_UNLIMITED;
  const Handle space(H5Screate_simple(1, &none, &unlimited), H5Sclose);
  const Handle chunked(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  if (H5Pset_chunk(chunked, 1, &chunk_rows) < 0) return false;
  return bool(
      Handle(H5Dcreate2(file, name, type, space, H5P_DEFAULT, chunked, H5P_DEFAULT), H5Dclose));
}

bool Table::open(hid_t file, const char* name) {
  set_ = Handle(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose);
  return bool(set_);
}

bool Table::write(hsize_t first, hsize_t count, const void* rows, hid_t type) {
  if (count == 0) return true;
  const hsize_t all = std::max(rows_, first + count);
  if (H5Dset_extent(set_, &all) < 0) return false;
  const Handle space(H5Dget_space(set_), H5Sclose);
  const Handle memory(H5Screate_simple(1, &count, nullptr), H5Sclose);
  if (H5Sselect_hyperslab(space, H5S_SELECT_SET, &first, nullptr, &count, nullptr) < 0 ||
      H5Dwrite(set_, type, memory, space, H5P_DEFAULT, rows) < 0) {
    return false;
  }
  rows_ = all;
  return true;
}

bool Matrix::create(hid_t file, const char* name, hid_t type, hsize_t columns, const void* fill) {
  const std::array<hsize_t, 2> none{0, 0}, unlimited{H5S_UNLIMITED, H5S_UNLIMITED};
  const hsize_t across = std::max<hsize_t>(columns, 1);
  const std::array<hsize_t, 2> chunk{
      std::clamp<hsize_t>(kMatrixChunkBytes / (across * H5Tget_size(type)), 1, kMatrixChunkRows),
      across};
  const Handle space(H5Screate_simple(2, none.data(), unlimited.data()), H5Sclose);
  const Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  if (H5Pset_chunk(layout, 2, chunk.data()) < 0 || H5Pset_fill_value(layout, type, fill) < 0) {
    return false;
  }
  return bool(
      Handle(H5Dcreate2(file, name, type, space, H5P_DEFAULT, layout, H5P_DEFAULT), H5Dclose));
}

bool Matrix::open(hid_t file, const char* name) {
  set_ = Handle(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose);
  return bool(set_);
}

/// Writes rows of the same length together; usually these are all.
bool Matrix::write(const void* cells, std::size_t cell_bytes,
                   std::span<const std::uint32_t> per_row, hid_t type) {
  if (per_row.empty()) return true;
  const std::array<hsize_t, 2> extent{rows_ + per_row.size(),
                                      std::max<hsize_t>(columns_, std::ranges::max(per_row))};
  if (H5Dset_extent(set_, extent.data()) < 0) return false;
  const auto* next = static_cast<const std::byte*>(cells);
  for (std::size_t from = 0, to = 0; from < per_row.size(); from = to) {
    const hsize_t count = per_row[from];
    while (to < per_row.size() && per_row[to] == count) ++to;
    if (count == 0) continue;
    if (!write_cells(set_, {rows_ + from, 0}, {to - from, count}, next, type)) return false;
    next += (to - from) * count * cell_bytes;
  }
  rows_ = extent[0];
  columns_ = extent[1];
  return true;
}

bool make_scale(hid_t file, const char* scale, std::span<const ScaledDimension> of) {
  const Handle values(H5Dopen2(file, scale, H5P_DEFAULT), H5Dclose);
  if (!values || H5DSset_scale(values, scale) < 0) return false;
  return std::ranges::all_of(of, [&](const ScaledDimension& one) {
    const Handle set(H5Dopen2(file, one.dataset, H5P_DEFAULT), H5Dclose);
    return set && H5DSattach_scale(set, values, one.dimension) >= 0 &&
           H5DSset_label(set, one.dimension, scale) >= 0;
  });
}

}  // namespace ovws::hdf5
