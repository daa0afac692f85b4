#include "drivers/hdf5/types.hpp"

#include <array>

namespace ovws::hdf5 {
namespace {

Handle field_type(FieldType type) {
  const std::array numbers{H5T_STD_U8LE,  H5T_STD_U32LE,  H5T_STD_U64LE,
                           H5T_STD_I64LE, H5T_IEEE_F32LE, H5T_IEEE_F64LE};
  if (std::size_t(type) < numbers.size()) return {H5Tcopy(numbers[std::size_t(type)]), H5Tclose};
  Handle text(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(text, type == FieldType::text16 ? 16 : 64);
  H5Tset_strpad(text, H5T_STR_NULLPAD);
  return text;
}

}  // namespace

Handle row_type(std::span<const RecordedField> fields, std::size_t size) {
  Handle row(H5Tcreate(H5T_COMPOUND, size), H5Tclose);
  for (const RecordedField& field : fields) {
    H5Tinsert(row, field.name, field.offset, field_type(field.type));
  }
  return row;
}

}  // namespace ovws::hdf5
