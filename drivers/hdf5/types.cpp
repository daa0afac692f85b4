#include "drivers/hdf5/types.hpp"

namespace ovws::hdf5 {
namespace {

Handle text_type(std::size_t length) {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, length);
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  return type;
}

Handle field_type(FieldType type) {
  switch (type) {
    case FieldType::u8:
      return {H5Tcopy(H5T_STD_U8LE), H5Tclose};
    case FieldType::u32:
      return {H5Tcopy(H5T_STD_U32LE), H5Tclose};
    case FieldType::u64:
      return {H5Tcopy(H5T_STD_U64LE), H5Tclose};
    case FieldType::i64:
      return {H5Tcopy(H5T_STD_I64LE), H5Tclose};
    case FieldType::f32:
      return {H5Tcopy(H5T_IEEE_F32LE), H5Tclose};
    case FieldType::f64:
      return {H5Tcopy(H5T_IEEE_F64LE), H5Tclose};
    case FieldType::text16:
      return text_type(16);
    case FieldType::text64:
      return text_type(64);
  }
  return {};
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
