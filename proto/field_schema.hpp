/// JSON Schemas (draft 2020-12) from field tables.
#pragma once

#include <cmath>
#include <string>
#include <type_traits>
#include <utility>

#include "proto/field_json.hpp"

namespace ovws {

/// What a schema is for: params may leave out all that is not required, results hold every field.
enum class SchemaOf { params, result };

/// Collects the schemas of structs, each once, for references by "#/$defs/NAME".
struct SchemaParts {
  SchemaOf of = SchemaOf::result;
  bool may_be_absent = false;  ///< the fields of an inlined optional are being put
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

inline void put_bounds(Json& schema, const Bounds& bounds) {
  if (std::isfinite(bounds.min)) schema["minimum"] = bounds.min;
  if (std::isfinite(bounds.max)) schema["maximum"] = bounds.max;
}

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

inline Json schema_of_tuple(std::size_t size, const Bounds& bounds) {
  FieldInfo sized;
  sized.min_size = sized.max_size = size;
  return schema_of_array(schema_of_number<double>(bounds), sized);
}

/// Without what is of single values.
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
  } else if constexpr (HasNames<T>) {
    return {{"type", "string"}, {"enum", Names<T>::all()}};
  } else if constexpr (std::is_same_v<T, Vec2> || std::is_same_v<T, std::array<double, 2>>) {
    return schema_of_tuple(2, field.bounds);
  } else if constexpr (HasTable<T>) {
    return schema_reference<T>(parts);
  } else if constexpr (is_named_list<T>) {
    return {
        {"type", "object"},
        {"additionalProperties", schema_of_value<typename T::value_type::second_type>(parts, {})}};
  } else if constexpr (std::is_same_v<T, Json>) {
    return Json::object();
  } else if constexpr (TextLike<T>) {
    return {{"type", "string"}};
  } else {
    FieldInfo element;
    element.bounds = field.bounds;
    return schema_of_array(schema_of_value<typename T::value_type>(parts, element), field);
  }
}

template <class S>
void put_schema(SchemaParts& parts, Json& properties, Json& required);

template <class, class Entry>
void put_entry(SchemaParts& parts, const Entry& entry, Json& properties, Json& required) {
  Json schema = schema_of_value<typename Entry::Value>(parts, entry);
  const bool or_absent = parts.may_be_absent && std::string_view(entry.absent) == "null";
  if (!is_optional<typename Entry::Value> && (entry.nullable || or_absent)) {
    schema = with_null(std::move(schema));
  }
  schema["description"] = entry.meaning;
  properties[entry.key] = std::move(schema);
  if (parts.of == SchemaOf::result || entry.required) required.push_back(entry.key);
}
template <class>
void put_entry(SchemaParts&, const Constant& entry, Json& properties, Json& required) {
  properties[entry.key] = {
      {"const", entry.text}, {"type", "string"}, {"description", entry.meaning}};
  required.push_back(entry.key);
}
template <class, class S, class T>
void put_entry(SchemaParts& parts, const Inlined<S, T>&, Json& properties, Json& required) {
  if constexpr (is_optional<T>) {
    const bool before = std::exchange(parts.may_be_absent, true);
    put_schema<typename T::value_type>(parts, properties, required);
    parts.may_be_absent = before;
  } else {
    put_schema<T>(parts, properties, required);
  }
}

template <class, class T>
void put_entry(SchemaParts& parts, const Based<T>&, Json& properties, Json& required) {
  put_schema<T>(parts, properties, required);
}

template <class S>
void put_schema(SchemaParts& parts, Json& properties, Json& required) {
  std::apply([&](const auto&... entry) { (put_entry<S>(parts, entry, properties, required), ...); },
             Table<S>::kFields);
}

template <class S>
Json object_schema(SchemaParts& parts) {
  Json properties = Json::object(), required = Json::array();
  put_schema<S>(parts, properties, required);
  Json schema{{"type", "object"}, {"properties", properties}, {"additionalProperties", false}};
  if (!required.empty()) schema["required"] = required;
  return schema;
}

template <class S>
Json schema_reference(SchemaParts& parts) {
  const char* const name = Table<S>::kName;
  if (!parts.parts.contains(name)) {
    parts.parts[name] = nullptr;  // it is being made
    parts.parts[name] = object_schema<S>(parts);
  }
  return {{"$ref", std::string("#/$defs/") + name}};
}

}  // namespace detail

template <class S>
Json Wire<JsonOf<S>>::schema(SchemaParts& parts, const FieldInfo&) {
  return detail::schema_reference<S>(parts);
}

/// A whole schema: of params, of a result, of a message.
template <HasTable S>
Json schema_of(SchemaOf of) {
  SchemaParts parts{of};
  Json schema = detail::object_schema<S>(parts);
  schema["$schema"] = "https://json-schema.org/draft/2020-12/schema";
  if (!parts.parts.empty()) schema["$defs"] = std::move(parts.parts);
  return schema;
}

}  // namespace ovws
