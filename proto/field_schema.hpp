/// JSON Schemas (draft 2020-12) generated from field tables.
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "proto/field_json.hpp"

namespace ovws {

/// Kind of JSON Schema. `params`: omitted fields, unless required, take their default. `change`:
/// omitted fields stay unchanged. `result`: every field is present, except left_out ones.
enum class SchemaOf { params, change, result };

/// Collects the schema of each struct once, so that other schemas refer to it by "#/$defs/NAME".
struct SchemaParts {
  SchemaOf of = SchemaOf::result;
  bool may_be_absent = false;  ///< true while the fields of an inlined optional are added
  Json parts = Json::object();
};

namespace detail {

template <class T>
Json schema_of_value(SchemaParts& parts, const FieldInfo& field);
template <class S>
Json schema_reference(SchemaParts& parts);

inline Json with_null(Json schema) {
  if (schema.contains("type")) {
    schema["type"] = Json::array({schema["type"], "null"});
    if (schema.contains("enum")) schema["enum"].push_back(nullptr);
    return schema;
  }
  return {{"anyOf", Json::array({std::move(schema), Json{{"type", "null"}}})}};
}

inline void erase_bounds(Json& schema) {
  if (!schema.is_structured()) return;
  if (schema.is_object()) {
    schema.erase("minimum");
    schema.erase("maximum");
  }
  for (Json& part : schema) erase_bounds(part);
}

inline Json reference_to(std::string_view name) {
  std::string path = "#/$defs/";
  path += name;
  return {{"$ref", path}};
}

inline void put_bounds(Json& schema, const Bounds& bounds) {
  if (std::isfinite(bounds.min)) schema["minimum"] = bounds.min;
  if (std::isfinite(bounds.max)) schema["maximum"] = bounds.max;
}

template <class T>
inline constexpr bool is_array = false;
template <class T, std::size_t N>
inline constexpr bool is_array<std::array<T, N>> = true;

template <class T>
Json schema_of_number(const Bounds& bounds) {
  Json schema{{"type", std::is_integral_v<T> ? "integer" : "number"}};
  put_bounds(schema, bounds);
  if (std::is_unsigned_v<T> && !schema.contains("minimum")) schema["minimum"] = 0;
  return schema;
}

inline Json schema_of_array(Json items, const FieldInfo& field) {
  Json schema{{"type", "array"}, {"items", std::move(items)}};
  if (field.min_size > 0) schema["minItems"] = field.min_size;
  if (field.max_size < std::numeric_limits<std::size_t>::max()) schema["maxItems"] = field.max_size;
  if (field.distinct) schema["uniqueItems"] = true;
  return schema;
}

inline Json schema_of_text(const FieldInfo& field) {
  Json schema{{"type", "string"}};
  if (field.names != nullptr) schema["enum"] = field.names();
  return schema;
}

inline Json schema_of_tuple(std::size_t size, Json items) {
  FieldInfo sized;
  sized.min_size = sized.max_size = size;
  return schema_of_array(std::move(items), sized);
}

/// Schema of a value's type, without the field's description, default and nullability.
template <class T>
Json schema_of_value(SchemaParts& parts, const FieldInfo& field) {
  if constexpr (HasWire<T>) {
    return Wire<T>::schema(parts, field);
  } else if constexpr (is_optional<T>) {
    return with_null(schema_of_value<typename T::value_type>(parts, field));
  } else if constexpr (std::is_same_v<T, bool>) {
    return {{"type", "boolean"}};
  } else if constexpr (std::is_arithmetic_v<T>) {
    return schema_of_number<T>(field.bounds);
  } else if constexpr (std::is_enum_v<T>) {
    return {{"type", "string"}, {"enum", (field.names != nullptr ? field.names : kNames<T>)()}};
  } else if constexpr (std::is_same_v<T, Vec2>) {
    Json number = schema_of_number<double>(field.bounds);
    return schema_of_tuple(2, field.nulls ? with_null(std::move(number)) : std::move(number));
  } else if constexpr (is_array<T>) {
    FieldInfo element;
    element.bounds = field.bounds;
    return schema_of_tuple(std::tuple_size_v<T>,
                           schema_of_value<typename T::value_type>(parts, element));
  } else if constexpr (HasTable<T>) {
    return schema_reference<T>(parts);
  } else if constexpr (is_named_list<T>) {
    using Value = typename T::value_type::second_type;
    Json schema{{"type", "object"}, {"additionalProperties", schema_of_value<Value>(parts, {})}};
    if (field.names != nullptr) schema["propertyNames"] = {{"enum", field.names()}};
    return schema;
  } else if constexpr (std::is_same_v<T, Json>) {
    return Json::object();
  } else if constexpr (TextLike<T>) {
    return schema_of_text(field);
  } else {
    FieldInfo element;
    element.bounds = field.bounds;
    element.nulls = field.nulls;
    Json items = schema_of_value<typename T::value_type>(parts, element);
    const bool number = std::is_floating_point_v<typename T::value_type>;
    return schema_of_array(number && field.nulls ? with_null(std::move(items)) : std::move(items),
                           field);
  }
}

template <class S>
void put_schema(SchemaParts& parts, Json& properties, Json& required);

template <class S, class Entry>
void put_default(Json& schema, const Entry& entry) {
  if constexpr (requires { entry.member; }) {
    if (entry.required) return;
    const S defaults{};
    const auto& value = defaults.*entry.member;
    if (!is_nothing(value)) schema["default"] = to_json(value);
  }
}

template <class S, class Entry>
void put_entry(SchemaParts& parts, const Entry& entry, Json& properties, Json& required) {
  using Value = std::remove_cvref_t<decltype(entry.of(std::declval<const S&>()))>;
  Json schema = schema_of_value<Value>(parts, entry);
  const bool or_absent = parts.may_be_absent && std::string_view(entry.absent) == "null";
  if (!is_optional<Value> && (entry.nullable || or_absent)) {
    schema = with_null(std::move(schema));
  }
  if (parts.of == SchemaOf::params) put_default<S>(schema, entry);
  schema["description"] = entry.meaning;
  properties[entry.key] = std::move(schema);
  const bool always = parts.of == SchemaOf::result && !entry.left_out;
  if (always || entry.required) required.push_back(entry.key);
}
template <class S>
void put_entry(SchemaParts&, const Constant& entry, Json& properties, Json& required) {
  properties[entry.key] = {
      {"const", entry.text}, {"type", "string"}, {"description", entry.meaning}};
  required.push_back(entry.key);
}
template <class Owner, class S, class T>
void put_entry(SchemaParts& parts, const Inlined<S, T>&, Json& properties, Json& required) {
  if constexpr (is_optional<T>) {
    const bool before = std::exchange(parts.may_be_absent, true);
    put_schema<typename T::value_type>(parts, properties, required);
    parts.may_be_absent = before;
  } else {
    put_schema<T>(parts, properties, required);
  }
}
template <class Owner, class T>
void put_entry(SchemaParts& parts, const Based<T>&, Json& properties, Json& required) {
  put_schema<T>(parts, properties, required);
}

template <class S>
void put_schema(SchemaParts& parts, Json& properties, Json& required) {
  kTable<S>.apply(
      [&](const auto&... entry) { (put_entry<S>(parts, entry, properties, required), ...); });
}

template <class S>
Json object_schema(SchemaParts& parts) {
  // A nested struct holds all its fields, even if the struct itself may be absent.
  const bool before = std::exchange(parts.may_be_absent, false);
  Json properties = Json::object(), required = Json::array();
  put_schema<S>(parts, properties, required);
  parts.may_be_absent = before;
  Json schema{{"type", "object"}, {"properties", properties}, {"additionalProperties", false}};
  if (!required.empty()) schema["required"] = required;
  if constexpr (requires { Rules<S>::schema(); }) schema.update(Rules<S>::schema());
  return schema;
}

template <class S>
Json schema_reference(SchemaParts& parts) {
  // A change needs a definition of its own, because none of its fields is required.
  const std::string name =
      std::string(kTable<S>.name) + (parts.of == SchemaOf::change ? "Change" : "");
  if (!parts.parts.contains(name)) {
    parts.parts[name] = nullptr;  // marks it as in progress
    parts.parts[name] = object_schema<S>(parts);
  }
  return reference_to(name);
}

}  // namespace detail

template <class S>
Json Wire<JsonOf<S>>::schema(SchemaParts& parts, const FieldInfo&) {
  return detail::schema_reference<S>(parts);
}

template <class S>
Json Wire<Partial<S>>::schema(SchemaParts& parts, const FieldInfo&) {
  SchemaParts asked{SchemaOf::change};
  Json reference = detail::schema_reference<S>(asked);
  detail::erase_bounds(asked.parts);  // a requested number may be out of range and clamped
  parts.parts.update(asked.parts);
  return reference;
}

/// The complete schema of params, a result or a message.
template <class S>
struct WholeSchema {
  static Json of(SchemaOf of) {
    SchemaParts parts{of};
    Json schema;
    if constexpr (HasTable<S>) {
      schema = detail::object_schema<S>(parts);
      schema["title"] = kTable<S>.name;
    } else {
      schema = Wire<S>::schema(parts, {});
    }
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema";
    if (!parts.parts.empty()) schema["$defs"] = std::move(parts.parts);
    return schema;
  }
};
template <class S>
struct WholeSchema<Partial<S>> {
  static Json of(SchemaOf) {
    Json schema = WholeSchema<S>::of(SchemaOf::change);
    schema["properties"]["clamp"] = {
        {"type", "boolean"},
        {"default", false},
        {"description",
         "true: a number out of range becomes the nearest limit instead of being refused; the "
         "ranges stated here then do not apply"}};
    return schema;
  }
};
template <class S>
Json schema_of(SchemaOf of) {
  return WholeSchema<S>::of(of);
}

}  // namespace ovws
