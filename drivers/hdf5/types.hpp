/// The rows of a recording as HDF5 types.
#pragma once

#include <span>

#include "drivers/hdf5/handle.hpp"
#include "proto/recording.hpp"

namespace ovws::hdf5 {

/// Compound of `size` bytes in this machine's order, which is that of the file, too: little-endian.
Handle row_type(std::span<const RecordedField> fields, std::size_t size);

}  // namespace ovws::hdf5
