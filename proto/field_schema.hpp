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

Json with_null(Json schema);
void erase_bounds(Json& schema);
Json reference_to(std::string_view name);
Json number_schema(bool integer, bool no_sign, const Bounds& bounds);
Json schema_of_array(Json items, const FieldInfo& field);
Json schema_of_text(const FieldInfo& field);
Json schema_of_names(NamesOf names);
Json schema_of_tuple(std::size_t size, Json items);
Json schema_of_list(Json items, bool floating, const FieldInfo& field);
Json schema_of_map(Json values, const FieldInfo& field);

template <class T>
inline constexpr bool is_array = false;
template <class T, std::size_t N>
inline constexpr bool is_array<std::array<T, N>> = true;

template <class T>
Json schema_of_number(const Bounds& bounds) {
  return number_schema(std::is_integral_v<T>, std::is_unsigned_v<T>, bounds);
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
    return schema_of_names(field.names != nullptr ? field.names : kNames<T>);
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
    return schema_of_map(schema_of_value<Value>(parts, {}), field);
  } else if constexpr (std::is_same_v<T, Json>) {
    return Json::object();
  } else if constexpr (TextLike<T>) {
    return schema_of_text(field);
  } else {
    FieldInfo element;
    element.bounds = field.bounds;
    element.nulls = field.nulls;
    return schema_of_list(schema_of_value<typename T::value_type>(parts, element),
                          std::is_floating_point_v<typename T::value_type>, field);
  }
}

template <class S>
void put_schema(SchemaParts& parts, Json& properties, Json& required);

/// How a type is described: its schema, and its encoding for the default value.
struct Describer {
  Json (*schema)(SchemaParts& parts, const FieldInfo& field);
  Encoder<Json> encoder;
  bool optional;
};
template <class T>
inline constexpr Describer kDescriber{schema_of_value<T>, kEncoder<Json, T>, is_optional<T>};

// Compiled once.
/// Adds the schema of one field. `initial`: its default value; null: it has none.
void put_field_schema(SchemaParts& parts, const FieldInfo& field, const Describer& describer,
                      const void* initial, Json& properties, Json& required);
void put_constant(const Constant& field, Json& properties, Json& required);
Json object_of(Json properties, Json required);

template <class S, class Entry>
void put_entry(SchemaParts& parts, const S& defaults, const Entry& entry, Json& properties,
               Json& required) {
  using Value = std::remove_cvref_t<decltype(entry.of(defaults))>;
  const void* initial = nullptr;
  if constexpr (requires { entry.member; }) initial = &(defaults.*entry.member);
  put_field_schema(parts, entry, kDescriber<Value>, initial, properties, required);
}
template <class S>
void put_entry(SchemaParts&, const S&, const Constant& entry, Json& properties, Json& required) {
  put_constant(entry, properties, required);
}
template <class Owner, class S, class T>
void put_entry(SchemaParts& parts, const Owner&, const Inlined<S, T>&, Json& properties,
               Json& required) {
  if constexpr (is_optional<T>) {
    const bool before = std::exchange(parts.may_be_absent, true);
    put_schema<typename T::value_type>(parts, properties, required);
    parts.may_be_absent = before;
  } else {
    put_schema<T>(parts, properties, required);
  }
}
template <class Owner, class T>
void put_entry(SchemaParts& parts, const Owner&, const Based<T>&, Json& properties,
               Json& required) {
  put_schema<T>(parts, properties, required);
}

template <class S>
void put_schema(SchemaParts& parts, Json& properties, Json& required) {
  const S defaults{};
  kTable<S>.apply([&](const auto&... entry) {
    (put_entry(parts, defaults, entry, properties, required), ...);
  });
}

template <class S>
Json object_schema(SchemaParts& parts) {
  // A nested struct holds all its fields, even if the struct itself may be absent.
  const bool before = std::exchange(parts.may_be_absent, false);
  Json properties = Json::object(), required = Json::array();
  put_schema<S>(parts, properties, required);
  parts.may_be_absent = before;
  Json schema = object_of(std::move(properties), std::move(required));
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

namespace detail {
Json whole_schema(Json schema, SchemaParts& parts);
Json with_clamp(Json schema);
}  // namespace detail

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
    return detail::whole_schema(std::move(schema), parts);
  }
};
template <class S>
struct WholeSchema<Partial<S>> {
  static Json of(SchemaOf) { return detail::with_clamp(WholeSchema<S>::of(SchemaOf::change)); }
};
template <class S>
Json schema_of(SchemaOf of) {
  return WholeSchema<S>::of(of);
}

}  // namespace ovws
