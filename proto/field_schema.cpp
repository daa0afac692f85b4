#include "proto/field_schema.hpp"

namespace ovws::detail {

Json with_null(Json schema) {
  if (schema.contains("type")) {
    schema["type"] = Json::array({schema["type"], "null"});
    if (schema.contains("enum")) schema["enum"].push_back(nullptr);
    return schema;
  }
  return {{"anyOf", Json::array({std::move(schema), Json{{"type", "null"}}})}};
}

void erase_bounds(Json& schema) {
  if (!schema.is_structured()) return;
  if (schema.is_object()) {
    schema.erase("minimum");
    schema.erase("maximum");
  }
  for (Json& part : schema) erase_bounds(part);
}

Json reference_to(std::string_view name) {
  std::string path = "#/$defs/";
  path += name;
  return {{"$ref", path}};
}

Json number_schema(bool integer, bool no_sign, const Bounds& bounds) {
  Json schema{{"type", integer ? "integer" : "number"}};
  if (std::isfinite(bounds.min)) schema["minimum"] = bounds.min;
  if (std::isfinite(bounds.max)) schema["maximum"] = bounds.max;
  if (no_sign && !schema.contains("minimum")) schema["minimum"] = 0;
  return schema;
}

Json schema_of_array(Json items, const FieldInfo& field) {
  Json schema{{"type", "array"}, {"items", std::move(items)}};
  if (field.min_size > 0) schema["minItems"] = field.min_size;
  if (field.max_size < std::numeric_limits<std::size_t>::max()) schema["maxItems"] = field.max_size;
  if (field.distinct) schema["uniqueItems"] = true;
  return schema;
}

Json schema_of_text(const FieldInfo& field) {
  Json schema{{"type", "string"}};
  if (field.names != nullptr) schema["enum"] = field.names();
  return schema;
}

Json schema_of_names(NamesOf names) {
  return {{"type", "string"}, {"enum", names()}};
}

Json schema_of_tuple(std::size_t size, Json items) {
  FieldInfo sized;
  sized.min_size = sized.max_size = size;
  return schema_of_array(std::move(items), sized);
}

Json schema_of_list(Json items, bool floating, const FieldInfo& field) {
  return schema_of_array(floating && field.nulls ? with_null(std::move(items)) : std::move(items),
                         field);
}

Json schema_of_map(Json values, const FieldInfo& field) {
  Json schema{{"type", "object"}, {"additionalProperties", std::move(values)}};
  if (field.names != nullptr) schema["propertyNames"] = {{"enum", field.names()}};
  return schema;
}

void put_field_schema(SchemaParts& parts, const FieldInfo& field, const Describer& describer,
                      const void* initial, Json& properties, Json& required) {
  Json schema = describer.schema(parts, field);
  const bool or_absent = parts.may_be_absent && std::string_view(field.absent) == "null";
  if (!describer.optional && (field.nullable || or_absent)) schema = with_null(std::move(schema));
  const bool has_default = parts.of == SchemaOf::params && !field.required && initial != nullptr;
  if (has_default && !describer.encoder.is_nothing(initial)) {
    schema["default"] = describer.encoder.encode(initial);
  }
  schema["description"] = field.meaning;
  properties[field.key] = std::move(schema);
  const bool always = parts.of == SchemaOf::result && !field.left_out;
  if (always || field.required) required.push_back(field.key);
}

void put_constant(const Constant& field, Json& properties, Json& required) {
  properties[field.key] = {
      {"const", field.text}, {"type", "string"}, {"description", field.meaning}};
  required.push_back(field.key);
}

Json object_of(Json properties, Json required) {
  const bool some = !required.empty();
  Json schema{
      {"type", "object"}, {"properties", std::move(properties)}, {"additionalProperties", false}};
  if (some) schema["required"] = std::move(required);
  return schema;
}

Json whole_schema(Json schema, SchemaParts& parts) {
  schema["$schema"] = "https://json-schema.org/draft/2020-12/schema";
  if (!parts.parts.empty()) schema["$defs"] = std::move(parts.parts);
  return schema;
}

Json with_clamp(Json schema) {
  schema["properties"]["clamp"] = {
      {"type", "boolean"},
      {"default", false},
      {"description",
       "true: a number out of range becomes the nearest limit instead of being refused; the "
       "ranges stated here then do not apply"}};
  return schema;
}

}  // namespace ovws::detail
