/// HDF5 compound types of a recording's rows.
#pragma once

#include <span>

#include "drivers/hdf5/handle.hpp"
#include "proto/recording.hpp"

namespace ovws::hdf5 {

/// HDF5 compound type of a row of `size` bytes. Memory and file both use little-endian byte order.
Handle row_type(std::span<const RecordedField> fields, std::size_t size);

}  // namespace ovws::hdf5
