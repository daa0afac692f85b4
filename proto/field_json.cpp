#include "proto/field_json.hpp"

namespace ovws::detail {

template <class J>
void put_field(J& out, const FieldInfo& field, const Encoder<J>& encoder, const void* value) {
  const bool nothing = (field.nullable || field.left_out) && encoder.is_nothing(value);
  J encoded = nothing ? J() : encoder.encode(value);
  if (!field.left_out || !encoded.is_null()) out[field.key] = std::move(encoded);
}

template <class J>
J number_or_null(double value) {
  return std::isfinite(value) ? J(value) : J();
}

template <class J>
J point(const Vec2& value) {
  return J::array({number_or_null<J>(value.x), number_or_null<J>(value.y)});
}

template <class J>
J parsed(const char* json) {
  return J::parse(json);
}

using Ordered = nlohmann::ordered_json;
template void put_field(Json&, const FieldInfo&, const Encoder<Json>&, const void*);
template void put_field(Ordered&, const FieldInfo&, const Encoder<Ordered>&, const void*);
template Json number_or_null(double);
template Ordered number_or_null(double);
template Json point(const Vec2&);
template Ordered point(const Vec2&);
template Json parsed(const char*);
template Ordered parsed(const char*);

void decode_points(ObjectReader& reader, const FieldInfo& field, std::vector<Vec2>& out) {
  const Json* const given = reader.raw(field.key);
  if (given == nullptr || reader.failed()) return;
  const auto fits = [&field](const Json& number) {
    if (number.is_null()) return field.nulls;
    return number.is_number() && number >= field.bounds.min && number <= field.bounds.max;
  };
  const auto value = [](const Json& number) {
    return number.is_null() ? std::numeric_limits<double>::quiet_NaN() : number.get<double>();
  };
  const auto is_point = [&fits](const Json& point) {
    return point.is_array() && point.size() == 2 && fits(point[0]) && fits(point[1]);
  };
  const std::size_t most = std::min(field.max_size, kMaxElements);
  if (!given->is_array() || given->size() < field.min_size || given->size() > most ||
      !std::all_of(given->begin(), given->end(), is_point)) {
    return reader.fault(field.key, "must be an array of " + std::to_string(field.min_size) +
                                       " to " + std::to_string(most) +
                                       " pairs [x, y] of numbers within their limits");
  }
  out.clear();
  for (const Json& point : *given) out.push_back({value(point[0]), value(point[1])});
}

}  // namespace ovws::detail
